#!/usr/bin/env python3
"""A drop of water on a pane, traced by Mitsuba 3, for crates/optics/tests/drops_mitsuba.rs.

    pip install mitsuba numpy
    python3 validation/mitsuba/drops.py > crates/optics/tests/data/mitsuba_drops.txt

Coordinates are the camera's: x right, y down, z along the optical axis; mm; the inner face is z = 0. The drop is a cap of
a sphere on the outer face, at the axis. Glass and water meet in one face, without air between them. The camera is a
pinhole that looks along the axis. A plane far away, as large as the frame, shines with red that rises from 0.1 to 0.9
across the frame, green that does so down it, and blue of 1: red over blue tells the column where light comes from, green
over blue the row, and blue how much of it passes. All else is black: what is beyond the frame, the camera's side, the
pane's rim.

Every face is smooth, light is unpolarized at each, and paths are followed through up to 200 of them. Glass and drop are
meshes with the same corners where they meet, so that no ray slips between them. The corners and normals of the cap are
those of its sphere; between them it is at most 2e-5 mm too low. (A sphere cut by a mask gave the same but for noise.)

A line is: thickness of the pane, mm; contact angle, degrees; then

- `whole`: mean of blue over the 48 x 48 px about the drop, of which some are bare glass;
- `row` and its number: what each pixel of a row of the frame shows, from the middle of the frame to the right, as columns
  (`u`), rows (`v`) and `blue`. It is the mean of both sides, of which the left is turned over. Where less than 0.02
  passes there is no place.
"""
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

# As in the test.
GLASS, WATER, RADIUS_MM, DISTANCE_MM = 1.52, 1.333, 2.0, 20.0
F_PX, WIDTH, HEIGHT = 240.0, 800, 600
HALF, ROWS = 24, (300, 312)
FAR_MM, PANE_MM = 1e5, 60.0
SECTORS, RINGS = 1024, 256
# Passes of so many paths per pixel: Mitsuba sums a pass in single precision, which more paths would bias.
PATHS, PASSES_OF_ROW, PASSES_OF_ALL = 1024, 64, 2

angles = 2 * np.pi * np.arange(SECTORS) / SECTORS
one = np.arange(SECTORS)
other = (one + 1) % SECTORS


def circle(radius, z):
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(SECTORS, z)], -1)


def band(inner, outer):
    """Triangles between two circles, by the indices of their first corners; they face +z if the first is within."""
    return np.concatenate([np.stack([inner + one, outer + one, outer + other], -1), np.stack([inner + one, outer + other, inner + other], -1)])


def fan(middle, outer):
    return np.stack([np.full(SECTORS, middle), outer + one, outer + other], -1)


def face(outside, inside):
    """A smooth face between two media, `outside` that to which the normal points."""
    return {"type": "dielectric", "ext_ior": outside, "int_ior": inside}


def mesh(name, corners, triangles, bsdf, normals=None):
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    made = mi.Mesh(name, len(corners), len(triangles), has_vertex_normals=normals is not None, props=properties)
    values = mi.traverse(made)
    values["vertex_positions"] = np.asarray(corners, np.float32).ravel()
    values["faces"] = np.asarray(triangles, np.uint32).ravel()
    if normals is not None:
        values["vertex_normals"] = np.asarray(normals, np.float32).ravel()
    values.update()
    return made


def cap(pane_mm, contact):
    """The cap: its rim is that of the footprint, corner by corner."""
    sphere = RADIUS_MM / np.sin(contact)
    center = np.array([0.0, 0.0, pane_mm - sphere * np.cos(contact)])
    polar = contact * np.arange(1, RINGS + 1) / RINGS
    corners = [center + [[0.0, 0.0, sphere]]]
    corners += [circle(sphere * np.sin(p), center[2] + sphere * np.cos(p)) for p in polar[:-1]]
    corners = np.concatenate([*corners, circle(RADIUS_MM, pane_mm)])
    triangles = [fan(0, 1)] + [band(1 + (k - 1) * SECTORS, 1 + k * SECTORS) for k in range(1, RINGS)]
    return mesh("cap", corners, np.concatenate(triangles), face(1.0, WATER), (corners - center) / sphere)


def scene(pane_mm, contact, crop):
    """The drop, or bare glass where there is no contact angle."""
    left, top, width, height = crop
    s = {"type": "scene", "integrator": {"type": "path", "max_depth": 200, "rr_depth": 1000}}
    s["sensor"] = {
        "type": "perspective",
        "fov": float(2 * np.degrees(np.arctan(0.5 * WIDTH / F_PX))),
        "fov_axis": "x",
        "near_clip": 0.1,
        "far_clip": 1e7,
        "to_world": T().look_at(origin=[0, 0, -DISTANCE_MM], target=[0, 0, 0], up=[0, -1, 0]),
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "pixel_format": "rgb", "rfilter": {"type": "box"}, "component_format": "float32",
                 "crop_offset_x": left, "crop_offset_y": top, "crop_width": width, "crop_height": height},
        "sampler": {"type": "independent", "sample_count": PATHS},
    }
    # The far plane: its texture has its first row at the bottom.
    columns, rows = (np.arange(WIDTH) + 0.5) / WIDTH, (np.arange(HEIGHT) + 0.5) / HEIGHT
    ramps = np.stack(np.broadcast_arrays(0.1 + 0.8 * columns[None, :], 0.1 + 0.8 * rows[::-1, None], 1.0), -1).astype(np.float32)
    reach = (FAR_MM + DISTANCE_MM) / F_PX
    towards_camera = np.diag([reach * WIDTH / 2, -reach * HEIGHT / 2, -1.0, 1.0])
    towards_camera[2, 3] = FAR_MM
    light = {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(ramps)), "raw": True, "filter_type": "bilinear", "wrap_mode": "clamp"}
    black = {"type": "diffuse", "reflectance": 0.0}
    s["far"] = {"type": "rectangle", "to_world": T(towards_camera), "bsdf": black, "emitter": {"type": "area", "radiance": light}}
    # The pane: a disc, whose rim is black.
    s["inner"] = {"type": "disk", "to_world": T(np.diag([PANE_MM, -PANE_MM, -1.0, 1.0])), "bsdf": face(1.0, GLASS)}
    s["rim"] = {"type": "cylinder", "p0": [0, 0, 1e-3], "p1": [0, 0, pane_mm - 1e-3], "radius": 0.999 * PANE_MM, "bsdf": black}
    if contact is None:
        s["outer"] = {"type": "disk", "to_world": T().translate([0, 0, pane_mm]).scale([PANE_MM, PANE_MM, 1]), "bsdf": face(1.0, GLASS)}
        return mi.load_dict(s)
    foot = circle(RADIUS_MM, pane_mm)
    s["outer"] = mesh("outer", np.concatenate([foot, circle(PANE_MM, pane_mm)]), band(0, SECTORS), face(1.0, GLASS))
    s["foot"] = mesh("foot", np.concatenate([foot, [[0, 0, pane_mm]]]), fan(SECTORS, 0), face(WATER, GLASS))
    s["cap"] = cap(pane_mm, contact)
    return mi.load_dict(s)


def picture(pane_mm, contact, crop, passes, paths=PATHS):
    made = scene(pane_mm, contact, crop)
    return np.mean([np.array(mi.render(made, spp=paths, seed=seed), np.float64) for seed in range(passes)], 0)


def places(rgb):
    """Columns and rows of the frame where light comes from, and how much it is."""
    blue = rgb[..., 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        u, v = ((rgb[..., k] / blue - 0.1) / 0.8 * size for k, size in enumerate((WIDTH, HEIGHT)))
    return u, v, blue


def check_bare_glass():
    """Bare glass moves nothing, and passes (1 - R)/(1 + R), but for noise."""
    u, v, blue = places(picture(2.1, None, (0, 0, WIDTH, HEIGHT), 1, 16))
    columns, rows = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    cos = 1 / np.sqrt(1 + ((columns - WIDTH / 2) ** 2 + (rows - HEIGHT / 2) ** 2) / F_PX**2)
    inside = np.sqrt(1 - (1 - cos * cos) / GLASS**2)
    reflected = (((cos - GLASS * inside) / (cos + GLASS * inside)) ** 2 + ((GLASS * cos - inside) / (GLASS * cos + inside)) ** 2) / 2
    assert abs(u - columns).max() < 1 and abs(v - rows).max() < 1, "the far plane is the frame"
    assert abs((blue / ((1 - reflected) / (1 + reflected))).mean() - 1) < 1e-3, "a plate passes what it is to"


def main():
    check_bare_glass()
    print(f"# Mitsuba {mi.__version__}, validation/mitsuba/drops.py")
    middle = WIDTH // 2
    for pane_mm in (0.1, 2.1):
        for degrees in (30, 45, 60, 75, 90):
            contact = np.radians(degrees)
            name = f"{pane_mm} {degrees}"
            whole = picture(pane_mm, contact, (middle - HALF, HEIGHT // 2 - HALF, 2 * HALF, 2 * HALF), PASSES_OF_ALL)
            print(f"{name} whole {whole[..., 2].mean():.4f}")
            for row in ROWS:
                rgb = picture(pane_mm, contact, (middle - HALF, row, 2 * HALF, 1), PASSES_OF_ROW)[0]
                mirrored = rgb[::-1].copy()
                # Red of the left half is that of the right half of a drop turned over, of columns WIDTH - u.
                mirrored[:, 0] = mirrored[:, 2] - mirrored[:, 0]
                both = 0.5 * (rgb + mirrored)[HALF:]
                u, v, blue = places(both)
                shown = blue >= 0.02
                for what, values, digits in (("u", u, 1), ("v", v, 1), ("blue", blue, 3)):
                    kept = values if what == "blue" else np.where(shown, values, np.nan)
                    print(name, "row", row, what, *(f"{value:.{digits}f}" for value in kept))


if __name__ == "__main__":
    main()
