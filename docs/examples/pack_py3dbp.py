"""Pack cartons with py3dbp, and find the first placement that loses its support.

Run: pip install py3dbp; python docs/examples/pack_py3dbp.py
"""

from py3dbp import Bin, Item, Packer

from stackdsl.packing import PackedBox, check

packer = Packer()
packer.add_bin(Bin("pallet", 1200, 800, 1500, 1000))
for number in range(4):
    packer.add_item(Item(f"wide-{number}", 700, 500, 250, 12))
for number in range(6):
    packer.add_item(Item(f"small-{number}", 300, 200, 200, 4))
packer.pack(bigger_first=True)

# A position is the lower corner of an item, and `get_dimension` its sides as it lies; x, y and z are in this order.
boxes = [
    PackedBox(item.name, tuple(map(float, item.position)), tuple(map(float, item.get_dimension())), float(item.weight))
    for item in packer.bins[0].items
]
boxes.sort(key=lambda box: box.corner[2])  # from the bottom up, as a packer places them
print(check(boxes, deck="EUR", unit="mm", friction=0.4))
