#!/usr/bin/env python3
"""Writes a small RGB-D sequence in the TUM layout, with ground truth that is exact.

    make_tiny_dataset.py <folder>

A textured wall at 2 m fills the picture of a 320x240 camera that moves parallel to it, two pixels to
the right a frame and every third frame one pixel down, so that each picture is a part of one large
texture and no interpolation is needed. Same bytes on every run.
"""

import pathlib
import random
import struct
import sys
import zlib

WIDTH, HEIGHT, FRAMES = 320, 240, 12
FOCAL_PX, DEPTH_M, UNITS_PER_M = 300.0, 2.0, 5000
STEP_RIGHT_PX = 2


def png(width, height, color_type, bit_depth, rows):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    header = struct.pack(">IIBBBBB", width, height, bit_depth, color_type, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows), 6)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def make_texture(width, height):
    """Overlapping rectangles of random grey, whose corners are the features."""
    generator = random.Random(7)
    texture = [bytearray([90] * width) for _ in range(height)]
    for _ in range(1500):
        left, top = generator.randrange(width), generator.randrange(height)
        right = min(width, left + generator.randint(4, 30))
        bottom = min(height, top + generator.randint(4, 30))
        value = bytes([generator.randrange(256)]) * (right - left)
        for row in texture[top:bottom]:
            row[left:right] = value
    return texture


def main(arguments):
    if len(arguments) != 1:
        print(__doc__)
        return 2
    folder = pathlib.Path(arguments[0])
    (folder / "rgb").mkdir(parents=True, exist_ok=True)
    (folder / "depth").mkdir(exist_ok=True)
    texture = make_texture(WIDTH + STEP_RIGHT_PX * FRAMES, HEIGHT + FRAMES)
    depth = png(WIDTH, HEIGHT, 0, 16,
                [struct.pack(">H", round(DEPTH_M * UNITS_PER_M)) * WIDTH] * HEIGHT)
    color_list, depth_list, poses = ["# colour images"], ["# depth images"], ["# ground truth"]
    for i in range(FRAMES):
        right_px, down_px = STEP_RIGHT_PX * i, i // 3
        time_s = f"{100.0 + i / 30.0:.6f}"
        rows = []
        for row in texture[down_px:down_px + HEIGHT]:
            gray = row[right_px:right_px + WIDTH]
            color = bytearray(3 * WIDTH)
            color[0::3] = color[1::3] = color[2::3] = gray
            rows.append(bytes(color))
        (folder / "rgb" / f"{time_s}.png").write_bytes(png(WIDTH, HEIGHT, 2, 8, rows))
        (folder / "depth" / f"{time_s}.png").write_bytes(depth)
        color_list.append(f"{time_s} rgb/{time_s}.png")
        depth_list.append(f"{time_s} depth/{time_s}.png")
        metres_per_px = DEPTH_M / FOCAL_PX
        poses.append(f"{time_s} {right_px * metres_per_px:.9f} {down_px * metres_per_px:.9f} 0 "
                     "0 0 0 1")
    for name, lines in (("rgb.txt", color_list), ("depth.txt", depth_list),
                        ("groundtruth.txt", poses)):
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "camera.yaml").write_text(
        f"%YAML 1.0\n---\nwidth_px: {WIDTH}\nheight_px: {HEIGHT}\n"
        f"fx_px: {FOCAL_PX}\nfy_px: {FOCAL_PX}\ncx_px: {WIDTH / 2 - 0.5}\n"
        f"cy_px: {HEIGHT / 2 - 0.5}\ndepth_units_per_m: {UNITS_PER_M}\nfps: 30\n"
        "groundtruth_frame: camera\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
