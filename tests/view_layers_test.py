#!/usr/bin/env python3
"""Panels, clicked in a window: the arrows of the layers (which lies on top changes, at once, and back), and what V shows: a time that is typed and slid,
light. What is drawn then is what `render` draws of such a scene.

    view_layers_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import os
import subprocess
import sys

import view_test

CAMERA = "20,-40,9000000,0,-90,0"
# Of the panel as it opens: its two rows, and in each the arrows, pixels of the window.
ROWS_Y = (43, 66)
UP_X, DOWN_X = 50, 70
LAYERS = {"day": "bluemarble_dec2004_5400x2700.jpg", "night": "night_lights_5400x2700.jpg"}


# Of the panel of V as it opens.
FOLD, TIME_FIELD, HOUR_END, LIGHT_BOX = (278, 42), (300, 66), (433, 112), (277, 227)


def scene_file(folder, name, bottom, top, light="enabled = false"):
    path = os.path.join(folder, name)
    with open(path, "w") as file:
        file.write('body = "earth"\ntiling = "cube"\n' + "".join(f'[[imagery]]\nsource = "{layer}.tdb"\nname = "{layer}"\n' for layer in (bottom, top)) +
                   f"[light]\n{light}\n")
    return path


def rendered(program, scene, folder, *more):
    out = os.path.join(folder, "rendered.png")
    subprocess.run([program, "render", scene, "--camera", CAMERA, "--size", "x".join(map(str, view_test.SIZE)), "--fov", str(view_test.FOV_DEGREES), "-o", out, *more],
                   check=True, stderr=subprocess.DEVNULL)
    return view_test.picture(out)[2]


def difference(one, other):
    return sum(abs(a - b) for p, q in zip(one, other) for a, b in zip(p, q)) / (3 * len(one))


def test_arrows(viewer, above):
    """`above`: the picture with each layer on top."""
    def click(x, row):
        viewer.move(x, ROWS_Y[row])
        viewer.xdotool("click", 1)

    def shows(layer):
        return lambda: difference(view_test.picture(viewer.screenshot())[2], above[layer]) < 1.0

    viewer.wait_until_complete()
    assert difference(above["day"], above["night"]) > 20.0, "both look alike"
    assert shows("night")(), "the last layer of the scene lies on top"
    viewer.key("i")
    view_test.wait_for("a panel", lambda: min(view_test.window_picture(viewer, "panel.png")[ROWS_Y[0] * view_test.SIZE[0] + DOWN_X]) > 150)
    click(DOWN_X, 0)
    view_test.wait_for("the picture of the day", shows("day"))
    # Arrows that lead nowhere: up from the top, down from the bottom.
    click(UP_X, 0)
    click(DOWN_X, 1)
    assert shows("day")(), "a layer went beyond the others"
    # The rows have changed places with their layers.
    click(UP_X, 1)
    view_test.wait_for("the picture of the night", shows("night"))
    viewer.key("i")


def click_at(viewer, at):
    viewer.move(*at)
    viewer.xdotool("click", 1)


def type_time(viewer, time):
    """Once the field has taken the click: all of it is selected, in another colour."""
    at = (TIME_FIELD[1] - 7) * view_test.SIZE[0] + TIME_FIELD[0]
    before = view_test.window_picture(viewer, "panel.png")[at]
    click_at(viewer, TIME_FIELD)
    view_test.wait_for("a field that listens", lambda: view_test.window_picture(viewer, "panel.png")[at] != before)
    viewer.xdotool("type", "--delay", 3, time)
    viewer.key("Return")
    view_test.wait_for("a field that has heard", lambda: view_test.window_picture(viewer, "panel.png")[at] == before)


def test_settings(viewer, unlit, at_time):
    """`at_time`: a function that draws the lit scene at a time."""
    def shows(wished):
        return lambda: difference(view_test.picture(viewer.screenshot())[2], wished) < 1.0

    day, midnight = at_time("2026-06-21T14:00Z"), at_time("2026-06-22T00:00Z")
    assert difference(day, midnight) > 10.0, "both look alike"
    viewer.wait_until_complete()
    viewer.key("v")
    view_test.wait_for("a panel", lambda: min(view_test.window_picture(viewer, "panel.png")[FOLD[1] * view_test.SIZE[0] + FOLD[0]]) > 150)
    type_time(viewer, "2026-06-21T14:00Z")
    view_test.wait_for("the day that was typed", shows(day))
    type_time(viewer, "no day at all")
    assert shows(day)(), "another time for what is none"
    click_at(viewer, HOUR_END)
    view_test.wait_for("the end of that day", shows(midnight))
    click_at(viewer, LIGHT_BOX)
    view_test.wait_for("a picture without light", shows(unlit))


def run_all(program, source, folder):
    for layer, raster in LAYERS.items():
        subprocess.run([program, "build", os.path.join(folder, f"{layer}.tdb"), os.path.join(source, "data/earth", raster), "--kind", "imagery",
                        "--tiling", "cube", "--max-level", "1"], check=True, stderr=subprocess.DEVNULL)
    scene = scene_file(folder, "night_above.toml", "day", "night")
    above = {"night": rendered(program, scene, folder), "day": rendered(program, scene_file(folder, "day_above.toml", "night", "day"), folder)}
    display = view_test.Display()
    viewer = None
    try:
        viewer = view_test.Viewer(program, display, folder, scene, CAMERA)
        test_arrows(viewer, above)
        viewer.end()
        sunlit = scene_file(folder, "sunlit.toml", "night", "day", 'sun = "clock"\n[clock]\nstart = "2026-01-01"')
        viewer = view_test.Viewer(program, display, folder, sunlit, CAMERA)
        test_settings(viewer, above["day"], lambda time: rendered(program, sunlit, folder, "--time", time))
    finally:
        if viewer:
            viewer.end()
        display.stop()


if __name__ == "__main__":
    sys.exit(view_test.main_of(run_all))
