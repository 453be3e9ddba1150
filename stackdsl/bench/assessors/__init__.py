"""Peers that move nothing: asked after each placement whether what is there stands, as exact statics is."""
