"""What ends a run on several processes before its time."""
USAGE, BAD_INPUT, IO = 2, 3, 4  # exit codes


class Failure(Exception):
    """What, where and what to do. `of_all`: every rank has seen it, and one is enough to say it."""

    def __init__(self, code, message, of_all=False):
        super().__init__(message)
        self.code, self.of_all = code, of_all
