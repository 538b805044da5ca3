#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# scripts/demo.sh [--window]: from a bare Debian 12 to a picture: sets up, builds, and renders an example headless with
# Blender into out/, as PNG and as multi-layer EXR. --window opens Blender's window on that scene instead.
set -euo pipefail
cd "$(dirname "$0")/.."
scene=examples/window_hall.blend
case "${1:-}" in
    --window) window=1 ;;
    "") window=0 ;;
    *) echo "usage: scripts/demo.sh [--window]" >&2 && exit 2 ;;
esac

stage() { # NAME COMMAND...
    local begin=$EPOCHREALTIME
    "${@:2}"
    printf '%-24s %6.1f s\n' "$1" "$(awk "BEGIN { print $EPOCHREALTIME - $begin }")"
}
install() {
    scripts/blender -b --version >/dev/null
}
render() {
    mkdir -p out build/logs
    local picture log=build/logs/demo.log
    picture=$PWD/out/$(basename "$scene" .blend)
    # One render, two files: what Blender holds of the multi-layer picture is saved a second time, as it is displayed.
    TYNDALL_DEMO_PICTURE=$picture scripts/blender -b "$scene" -E TYNDALL --python-exit-code 1 --python-expr '
import bpy, os
picture = os.environ["TYNDALL_DEMO_PICTURE"]
scene = bpy.context.scene
render = scene.render
# A first look: the file itself asks for full HD.
render.resolution_percentage = 50
render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
render.filepath = picture + ".exr"
bpy.ops.render.render(write_still=True)
render.image_settings.file_format = "PNG"
bpy.data.images["Render Result"].save_render(picture + ".png")
' >"$log" 2>&1 </dev/null || { tail -n 5 "$log" >&2 && echo "demo: the render failed, see $log" >&2 && return 1; }
}

stage "set-up" scripts/setup.sh
stage "build and package" scripts/package.sh
stage "install into Blender" install
if ((window)); then
    # Blender opens a file that was saved without a window in front of its outer walls.
    exec scripts/blender "$scene" -E TYNDALL --python-expr '
import bpy
for area in bpy.context.window.screen.areas:
    space = area.spaces.active
    if area.type == "VIEW_3D":
        space.region_3d.view_perspective = "CAMERA"
        space.shading.type = "RENDERED"
        space.overlay.show_overlays = False
    elif area.type == "PROPERTIES":
        space.context = "RENDER"
'
fi
stage "render" render
ls -l --time-style=+ out/"$(basename "$scene" .blend)".{png,exr} | awk -v folder="$PWD" '{ print folder "/" $NF " (" $5 " bytes)" }'
