"""The command `graph`: one module a subcommand."""


def command() -> int:
    """Runs the command line of this process; a signal that ends it is one line, also while it is being imported."""
    try:
        import signal

        from graph.base.signals import ENDING

        for number in ENDING[1:]:
            if signal.getsignal(number) == signal.SIG_DFL:  # nohup ignores one
                signal.signal(number, signal.default_int_handler)  # raises KeyboardInterrupt, as Ctrl-C does
        from .main import main

        return main()
    except KeyboardInterrupt:
        import os

        os.write(2, b"graph: interrupted\n")
        return 130
