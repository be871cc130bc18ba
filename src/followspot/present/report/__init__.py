"""One page that shows and explains the renderer, made from its own output."""
