"""Who hears of events by a bound method, which ends with its object."""


class Listener:
    """Notes the arguments of each call."""

    def __init__(self):
        self.heard = []

    def listen(self, *args):
        self.heard.append(args)
