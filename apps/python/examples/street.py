import starbreak
from PIL import Image  # any reader of images will do: starbreak works on uint8 arrays

street, objects = starbreak.street_scene()  # or numpy.asarray(Image.open("photo.png"))
recipe = starbreak.Recipe("windshield-spiderweb", set={"impact.position": [0.72, 0.55]})
cracked = starbreak.crack(street, recipe, seed=7, boxes=[thing["box_px"] for thing in objects])
for thing, damage in zip(objects, cracked.damage):
    if damage["region_share"] > 0.2:
        print(thing["category"], damage)
Image.fromarray(cracked.image).save("cracked.jpg", quality=90)
