"""Where popsteer plugs in: other people's simulators and middleware, each in a module of its own.

An adapter converts, and calls the API; it has no control law of its own. Each needs an extra, which
is imported where it is used: importing an adapter's module needs numpy alone.
"""
