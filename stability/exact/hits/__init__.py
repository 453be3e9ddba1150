"""What a hit does to frozen bricks: whom it reaches, who rides along, who is pressed beyond what the proof allows."""
