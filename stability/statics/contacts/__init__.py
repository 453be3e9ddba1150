"""Where two boxes, or a box and a plane, touch: exact contacts from poses and sizes alone."""
