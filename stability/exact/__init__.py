"""The extension whose verdicts are proven: freezes what exact statics shows to stand, wakes what it shows to move."""
