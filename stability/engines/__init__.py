"""What the extension asks of a physics engine, and the engines that answer."""
