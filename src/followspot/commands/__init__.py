"""The commands: what is typed for each, taken apart and handed to ``present``.

What draws is imported inside of them: neither help nor a mistake waits for it.
"""
