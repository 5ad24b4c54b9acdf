#!/usr/bin/env python3
"""Writes a small RGB-D sequence in the TUM layout, with ground truth that is exact.

    make_tiny_dataset.py <folder>

A textured wall at 3 m with textured boards 1.5 m in front of it fills the picture of a 320x240 camera
that moves parallel to both, 10 mm to the right a frame and every third frame 10 mm down. The wall then
moves by one pixel where the boards move by two, so that no interpolation is needed. Same bytes on
every run.
"""

import pathlib
import random
import struct
import sys
import zlib

WIDTH, HEIGHT, FRAMES = 320, 240, 12
FOCAL_PX, UNITS_PER_M = 300.0, 5000
WALL_DEPTH_M, BOARD_DEPTH_M = 3.0, 1.5
STEP_M = WALL_DEPTH_M / FOCAL_PX  # one pixel of the wall
BOARD_STEP_PX = 2
NUM_BOARDS = 14


def png(width, height, color_type, bit_depth, rows):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    header = struct.pack(">IIBBBBB", width, height, bit_depth, color_type, 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + row for row in rows), 6)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def make_texture(generator, width, height, num_rectangles):
    """Overlapping rectangles of random grey, whose corners are the features."""
    texture = [bytearray([90] * width) for _ in range(height)]
    for _ in range(num_rectangles):
        left, top = generator.randrange(width), generator.randrange(height)
        right = min(width, left + generator.randint(4, 30))
        bottom = min(height, top + generator.randint(4, 30))
        value = bytes([generator.randrange(256)]) * (right - left)
        for row in texture[top:bottom]:
            row[left:right] = value
    return texture


def make_boards(generator):
    """[(left, top, texture)] in pixels of the first picture."""
    boards = []
    for _ in range(NUM_BOARDS):
        width, height = generator.randint(30, 60), generator.randint(30, 60)
        boards.append((generator.randrange(WIDTH), generator.randrange(HEIGHT),
                       make_texture(generator, width, height, 60)))
    return boards


def picture(wall, boards, steps_right, steps_down):
    """Grey values and raw depths, one bytes-like row each, as seen after so many steps."""
    gray = [bytearray(row[steps_right:steps_right + WIDTH])
            for row in wall[steps_down:steps_down + HEIGHT]]
    wall_depth = struct.pack(">H", round(WALL_DEPTH_M * UNITS_PER_M))
    board_depth = struct.pack(">H", round(BOARD_DEPTH_M * UNITS_PER_M))
    depth = [bytearray(wall_depth * WIDTH) for _ in range(HEIGHT)]
    for left, top, texture in boards:
        left -= BOARD_STEP_PX * steps_right
        top -= BOARD_STEP_PX * steps_down
        first, last = max(0, left), min(WIDTH, left + len(texture[0]))
        if first >= last:
            continue
        for i, row in enumerate(texture):
            if 0 <= top + i < HEIGHT:
                gray[top + i][first:last] = row[first - left:last - left]
                depth[top + i][2 * first:2 * last] = board_depth * (last - first)
    return gray, depth


def main(arguments):
    if len(arguments) != 1:
        print(__doc__)
        return 2
    folder = pathlib.Path(arguments[0])
    (folder / "rgb").mkdir(parents=True, exist_ok=True)
    (folder / "depth").mkdir(exist_ok=True)
    generator = random.Random(7)
    wall = make_texture(generator, WIDTH + FRAMES, HEIGHT + FRAMES, 1500)
    boards = make_boards(generator)
    color_list, depth_list, poses = ["# colour images"], ["# depth images"], ["# ground truth"]
    for i in range(FRAMES):
        time_s = f"{100.0 + i / 30.0:.6f}"
        gray, depth = picture(wall, boards, i, i // 3)
        color = []
        for row in gray:
            color.append(bytearray(3 * WIDTH))
            color[-1][0::3] = color[-1][1::3] = color[-1][2::3] = row
        (folder / "rgb" / f"{time_s}.png").write_bytes(png(WIDTH, HEIGHT, 2, 8, color))
        (folder / "depth" / f"{time_s}.png").write_bytes(png(WIDTH, HEIGHT, 0, 16, depth))
        color_list.append(f"{time_s} rgb/{time_s}.png")
        depth_list.append(f"{time_s} depth/{time_s}.png")
        poses.append(f"{time_s} {i * STEP_M:.9f} {i // 3 * STEP_M:.9f} 0 0 0 0 1")
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
