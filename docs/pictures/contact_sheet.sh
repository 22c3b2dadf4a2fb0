#!/usr/bin/env bash
# Draws the pictures of docs/pictures/contact_sheet.jpg, out of the demo's tile databases (./bootstrap demo). Needs
# ImageMagick's montage.
#   docs/pictures/contact_sheet.sh [PROGRAM] [FOLDER_FOR_THE_PICTURES]
set -euo pipefail
root=$(realpath "$(dirname "$0")/../..")
program=$(realpath "${1:-$root/build/release/bin/tellurion}")
work=${2:-$(mktemp -d)}
mkdir -p "$work"
night=$work/night.toml
size=640x480

# Air, stars and lamps, with the sun where a picture wants it.
sed "s|source = \"|&$root/data/|" "$root/data/earth_sun.toml" >"$night"

draw() { # NAME SCENE CAMERA ARGUMENTS...
  local name=$1 scene=$2 camera=$3
  shift 3
  "$program" render "$scene" --camera "$camera" --size "$size" -o "$work/$name.png" "$@"
}
mars() { draw "$@" --set atmosphere.enabled=true --set sky.enabled=true; }

draw 'Dawn from orbit' "$night" 20,10,400000,90,-18 --set 'light.sun=[0,118]' &
draw 'Terminator, city lights' "$night" 40,25,5000000,0,-90 --set 'light.sun=[10,-62]'
wait
draw 'Sunset from the ground' "$night" 40,-30,2,250,4 --set 'light.sun=[0,-118]' &
draw "The sun's glint on the sea" "$night" 36,20,300000,285,-35 --time 2026-06-21T16:30:00Z
wait
draw 'Himalaya in haze' "$night" 27.75,86.82,9500,20,-12 --set 'light.sun=[10,60]' --set atmosphere.aerosol_depth=0.15 &
mars 'Mars from orbit' "$root/data/mars.toml" 0,-60,8000000 --set 'light.sun=[10,-90]'
wait
mars 'Blue sunset on Mars' "$root/data/mars.toml" -14.6,175.5,-1500,270,5 --set 'light.sun=[-10,87]' &
size=480x480 draw 'Fisheye' "$night" 27.98,86.92,20000,250,0 --set 'light.sun=[10,10]' --projection fisheye --tilt 75 --aperture 200
wait
draw 'Stereo pair' "$night" 27.75,86.82,9500,20,-12 --set 'light.sun=[10,60]' --projection stereo

cd "$work"
montage -font DejaVu-Sans -pointsize 15 -background '#101014' -fill white -label '%t' 'Dawn from orbit.png' 'Terminator, city lights.png' \
  'Sunset from the ground.png' "The sun's glint on the sea.png" 'Himalaya in haze.png' 'Mars from orbit.png' \
  'Blue sunset on Mars.png' Fisheye.png 'Stereo pair.png' -tile 3x -geometry 480x360+5+5 -quality 84 -strip contact_sheet.jpg
echo "$work/contact_sheet.jpg"
