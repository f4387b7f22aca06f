"""Exit codes of ``irg``."""

DONE, SOME_FAILED, WRONG_USE, OTHER_SCENE, INTERRUPTED = 0, 1, 2, 3, 130
