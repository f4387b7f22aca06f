"""Words of a long function for its user, kept in a list."""


class Heard(list):
    """List of the lines that a long function reports, if its ``progress`` is `hear`."""

    def hear(self, progress):
        if progress.words:
            self.append(progress.words)
