"""What `run.py` offers on the command line, one command a module: each has `main(arguments, root) -> exit status`."""
