"""The command `graph`: one module for each subcommand."""


def command() -> int:
    """Runs the command line of this process. A signal that ends it prints one line, also during the imports."""
    try:
        import signal

        from graph.base.signals import ENDING

        for number in ENDING[1:]:
            if signal.getsignal(number) == signal.SIG_DFL:  # nohup ignores this signal
                signal.signal(number, signal.default_int_handler)  # raises KeyboardInterrupt, as Ctrl-C does
        from .main import leave, main

        return leave(main())
    except KeyboardInterrupt:
        import os

        os.write(2, b"graph: interrupted\n")
        return 130
