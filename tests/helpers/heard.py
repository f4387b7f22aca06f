"""Words of a long function for its user, kept in a list."""


class Heard(list):
    """Lines that a function says, whose ``progress`` is `hear`."""

    def hear(self, progress):
        if progress.words:
            self.append(progress.words)
