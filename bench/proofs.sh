#!/usr/bin/env bash
# The long proofs of what docs/measurements.md says of the surface, whole, and a table of what they found:
#   bench/proofs.sh [--share F] [--programs FOLDER] [--logs FOLDER] [COLLECTION]
# On each tiling 300 cameras at tolerances 0.5, 1 and 4, 2,000 frames without a hole, and the 30 s flight with and without
# morphing at tolerance 1, by place alone at 3 too; then centimetres, depth and exaggeration. --share 0.05 does a twentieth. COLLECTION is the
# developers' collection of data, which adds places with samples a metre apart: without, the cameras are shared out over
# three places in place of five. PROGRAMS: where the tests are (build/release/bin). Two run at a time, and say when they are
# done; what each printed is in LOGS (build/proofs). Exit status 1 where a proof fails.
set -euo pipefail
cd "$(dirname "$0")/.."
share=1
programs=build/release/bin
logs=build/proofs
collection=
while (($#)); do
  case $1 in
    --share) share=${2:?"--share F"} && shift 2 ;;
    --programs) programs=${2:?"--programs FOLDER"} && shift 2 ;;
    --logs) logs=${2:?"--logs FOLDER"} && shift 2 ;;
    -*) echo "proofs.sh: there is no option '$1'" >&2 && exit 2 ;;
    *) collection=$1 && shift ;;
  esac
done
[[ -z $collection || -d $collection ]] || { echo "proofs.sh: '$collection' is no folder" >&2 && exit 2; }
awk -v f="$share" 'BEGIN { exit !(f > 0 && f <= 1) }' || { echo "proofs.sh: --share takes a number above 0, up to 1" >&2 && exit 2; }
for program in depth_truth_tests no_hole_tests flight_tests render_tests scene_tests; do
  [[ -x $programs/$program ]] || { echo "proofs.sh: $programs/$program is not there: build it, or say --programs" >&2 && exit 2; }
done
rm -rf "$logs"
mkdir -p "$logs"

# part WHOLE LEAST: the share of a number, rounded up.
part() { awk -v n="$1" -v least="$2" -v f="$share" 'BEGIN { m = n * f; m = m > int(m) ? int(m) + 1 : m; print (m > least ? m : least) }'; }

places=$([[ -n $collection ]] && echo 5 || echo 3)
cameras=$(part $((300 / places)) 3)
frames=$(part 2000 20)
seconds=$(part 30 1)
names=()
declare -A commands
# job NAME COMMAND...
job() {
  names+=("$1")
  commands[$1]=$(printf '%q ' "${@:2}")
}
for tiling in healpix geographic cube; do
  job "depth_$tiling" "$programs/depth_truth_tests" --gtest_filter="Schemes/DepthTruth.*/$tiling" --seed=11 --cameras="$cameras" \
    --tolerance=0.5,1,4 --collection="$collection"
done
for tiling in healpix geographic cube; do
  job "flight_$tiling" "$programs/flight_tests" --gtest_filter="Schemes/SlowFlight.*/$tiling:-*PlaceAlone*" --from=$((30 - seconds)) --seconds="$seconds" \
    --tolerance=1 --control-frames="$(part 60 6)"
  job "flight_by_place_$tiling" "$programs/flight_tests" --gtest_filter="*PlaceAlone/$tiling" --from=$((30 - seconds)) --seconds="$seconds" --tolerance=1,3
done
for tiling in healpix geographic cube; do
  job "holes_$tiling" "$programs/no_hole_tests" --gtest_filter="Schemes/NoHole.*/$tiling" --frames="$frames"
done
job centimetres "$programs/render_tests" --gtest_filter='*Precision*:DepthRange*'
job exaggeration "$programs/scene_tests" --gtest_filter='*Exaggeration*'

echo "share $share: $cameras cameras at each of $places places, $frames frames, $seconds s of flight, on each tiling; ${#names[@]} jobs"
started=$SECONDS
run_one() {
  local start=$SECONDS
  local result=passed
  local TIMEFORMAT='%U'
  { time bash -c "${commands[$1]}" >"$logs/$1.log" 2>&1; } 2>"$logs/$1.cpu" || result=FAILED
  echo "$result $((SECONDS - start)) $(tail -n 1 "$logs/$1.cpu")" >"$logs/$1.result"
  echo "$(date +%H:%M:%S) $1 $result after $((SECONDS - start)) s; $(find "$logs" -name '*.result' | wc -l) of ${#names[@]} done"
}
for name in "${names[@]}"; do
  while (($(jobs -rp | wc -l) >= 2)); do wait -n || true; done
  run_one "$name" &
done
wait

python3 - "$logs" $((SECONDS - started)) <<'PY'
import collections, pathlib, re, sys
logs, seconds = pathlib.Path(sys.argv[1]), int(sys.argv[2])
text = {path.stem: path.read_text(errors="replace") for path in sorted(logs.glob("*.log"))}

def table(title, *rows):
    print(f"\n{title}\n")
    rows = [list(map(str, row)) for row in rows]
    for i, row in enumerate(rows):
        print("| " + " | ".join(row) + " |")
        if i == 0:
            print("| " + " | ".join(["---"] * len(row)) + " |")

HEAD = re.compile(r"^(\w+) +(\w+) +tolerance ([\d.]+) px: (\d+) cameras; max_screen_error_px ([\d.]+)")
TALLY = re.compile(r"^  (finest ground|source rasters): +(\d+) pixels, ([\d.]+)% within the tolerance, ([\d.]+)% within a pixel, worst ([\d.inf]+) px")
sums = collections.OrderedDict()
for name in sorted(text):
    for line in text[name].splitlines():
        if head := HEAD.match(line):
            place, tiling, tolerance, count, error = head.groups()
        elif tally := TALLY.match(line):
            against, pixels, within, near, worst = tally.groups()
            s = sums.setdefault((against, tiling, float(tolerance)), [0, 0, 0.0, 0.0, 0.0, 0.0])
            n = int(pixels)
            s[0] += int(count)
            s[1] += n
            s[2] += n * float(within)
            s[3] += n * float(near)
            s[4] = max(s[4], float(worst))
            s[5] = max(s[5], float(error))
table("Pictures against rays", ["against", "tiling", "tolerance, px", "cameras", "pixels", "within the tolerance", "within a pixel", "worst, px",
                                "max_screen_error_px"],
      *[[against, tiling, tolerance, s[0], s[1], f"{s[2] / max(s[1], 1):.4f}%", f"{s[3] / max(s[1], 1):.4f}%", f"{s[4]:.2f}", f"{s[5]:.4f}"]
        for (against, tiling, tolerance), s in sorted(sums.items())])

HOLES = re.compile(r"^(\w+) +(whole|late) +seed (\d+): +(\d+) frames, +(\d+) incomplete, (\d+) capped, +(\d+) morphing, (\d+) exaggerated, "
                   r"(\d+) tiles overtaken; (\d+) pixels, .*; (\d+) holes")
found = [HOLES.match(line).groups() for log in text.values() for line in log.splitlines() if HOLES.match(line)]
table("Background through the ground", ["tiling", "tiles come", "seed", "frames", "incomplete", "capped", "morphing", "over 5 times as high", "overtaken tiles",
                                        "pixels", "holes"], *found)

FLIGHT = re.compile(r"^(\w+) +(.*?) +largest jump (.*?) over [\d.]+ px; new tiles' vertices (.*?); between (.*?); +(\d+) tiles")
found = [FLIGHT.match(line).groups() for log in text.values() for line in log.splitlines() if FLIGHT.match(line)]
table("Jumps of the ground, over 0.5 px", ["tiling", "flight", "places all along", "vertices of new tiles", "between them", "tiles"], *found)

results = {name: (logs / f"{name}.result").read_text().split() for name in text}
table("Jobs", ["job", "result", "seconds", "of a processor"], *[[name, *result] for name, result in results.items()])
failed = [name for name, result in results.items() if result[0] != "passed"]
print(f"\n{len(results) - len(failed)} of {len(results)} passed, {seconds} s in all, {sum(float(r[2]) for r in results.values()):.0f} s of a processor" + (f"; see {logs}/{{{','.join(failed)}}}.log" if failed else ""))
sys.exit(1 if failed else 0)
PY
