"""The run on several processes that distributed.py starts: every function that takes `ranks` must be called on all of them at once."""
