#!/usr/bin/env bash
# Checks the distributed solver where MPI and MUMPS are installed: packages/mumps/check.sh [CONSERVA]
# The program conserva must have been built. CELLS=14 is the size of the blocks on which memory is measured.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
conserva="$(realpath "${1:-$here/../../target/release/conserva}")"
if ! command -v mpirun >/dev/null || ! command -v mpicc >/dev/null || [ ! -e /usr/include/dmumps_c.h ]; then
    echo "SKIPPED: MPI or MUMPS are not installed (Debian: libmumps-dev libopenmpi-dev openmpi-bin)" >&2
    exit 0
fi
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
export CONSERVA_MUMPS="$folder/conserva-mumps"
# For machines with fewer cores than ranks, and for root in containers.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
job=(mpirun --oversubscribe --bind-to none)
script="$here/block.rhai"
fail() { echo "FAILED: $*" >&2; exit 1; }
run() { "${launcher[@]}" "$conserva" run "$script" --quiet "$@" >"$folder/log" 2>&1; }
summary() { python3 -c "import json; s = json.load(open('$folder/$1/summary.json')); print($2)"; }

"$here/build.sh" "$folder"
python3 "$here/check.py" "$CONSERVA_MUMPS"

echo "-- the same solution, with ties (symmetric), friction (unsymmetric), one to four ranks, started by conserva and by mpirun"
for friction in 0.0 0.3; do
    arguments=(--set "friction=$friction")
    launcher=(env)
    run "${arguments[@]}" --solver direct --out "$folder/direct"
    for ranks in 1 2 4; do
        launcher=(env)
        run "${arguments[@]}" --solver mumps --ranks $ranks --out "$folder/own$ranks" || fail "$(cat "$folder/log")"
        launcher=("${job[@]}" -n $ranks)
        run "${arguments[@]}" --solver mumps --out "$folder/job$ranks" || fail "$(cat "$folder/log")"
        for found in own job; do
            [ "$(summary $found$ranks "s['solver'], len(s['rank_memory_bytes'])")" = "mumps $ranks" ] || fail "solver of $found$ranks"
            # Without contact to round-off; the gap of a closed contact is round-off itself, and slips are differences of positions.
            [ $friction = 0.0 ] && close=(--tolerance 1e-12) || close=(--tolerance 1e-11 --ignore contact_gap)
            "$conserva" diff "$folder/direct" "$folder/$found$ranks" "${close[@]}" >"$folder/diff" \
                || fail "friction $friction, $found$ranks: $(cat "$folder/diff")"
        done
    done
done

echo "-- the same bytes when a run is repeated"
launcher=(env)
for ranks in 1 2 4; do
    run --solver mumps --ranks $ranks --out "$folder/again"
    run --solver mumps --ranks $ranks --out "$folder/first"
    if "$conserva" diff "$folder/first" "$folder/again" >/dev/null; then
        echo "$ranks ranks: the same bytes"
    else
        [ $ranks -gt 1 ] || fail "one rank gives other bytes"
        echo "$ranks ranks: other last digits"
    fi
done

echo "-- memory of a rank: at most 0.65 and 0.4 of that of one"
for ranks in 1 2 4; do
    script="$here/../../benches/performance/blocks.rhai" run --set "n=${CELLS:-14}" --solver mumps --ranks $ranks --out "$folder/large$ranks"
    echo "$ranks ranks: $(summary large$ranks "s['unknowns'], 'unknowns,', [b / 1e6 for b in s['rank_memory_bytes']], 'MB', s['wall_seconds']['factorization'], 's'")"
done
most() { summary "large$1" "max(s['rank_memory_bytes'])"; }
python3 -c "one, two, four = $(most 1), $(most 2), $(most 4); print(f'{two / one:.2f} {four / one:.2f}'); assert two <= 0.65 * one and four <= 0.4 * one"

# Ends a run in the middle, and resumes it: lose NAME SIGNAL VICTIM [ARGUMENTS]; `launcher` is the command before that of Conserva.
lose() {
    rm -rf "$folder/lost"
    (code=0
    "${launcher[@]}" "$conserva" run "$script" --quiet --set steps=2000 --set friction=0.3 --solver mumps "${@:4}" --out "$folder/lost" \
        >"$folder/log" 2>&1 || code=$?
    echo $code >"$folder/code") &
    for _ in $(seq 300); do
        rows="$( (wc -l <"$folder/lost/history.csv") 2>/dev/null || echo 0)"
        [ "$rows" -gt 4 ] && break
        sleep 0.1
    done
    case $3 in
    rank) victim="$(pgrep -f "^$CONSERVA_MUMPS" | tail -1)" ;;
    conserva) victim="$(pgrep -f "^$conserva run $script" | head -1)" ;;
    launcher) victim="$(pgrep -f "^mpirun .*$script" | head -1)" ;;
    esac
    kill "-$2" "$victim"
    wait
    # An interrupted mpirun does not wait for its processes.
    for _ in $(seq 200); do pgrep -f "^$conserva run $script" >/dev/null || break; sleep 0.1; done
    [ "$(cat "$folder/code")" != 0 ] || fail "$1: the exit code is 0"
    ls "$folder/lost/checkpoints/"*.checkpoint >/dev/null 2>&1 || fail "$1: no checkpoint: $(cat "$folder/log")"
    reached="$(tail -1 "$folder/lost/history.csv" | cut -d, -f2)"
    "$conserva" resume "$folder/lost" --solver direct --quiet --until "$(python3 -c "print($reached + 0.03)")" >"$folder/log2" 2>&1 \
        || fail "$1: $(cat "$folder/log2")"
    echo "$1: code $(cat "$folder/code"), $(grep -m1 -h error "$folder/log"); resumed"
}
echo "-- a run that loses a rank, or is interrupted, ends with a checkpoint"
launcher=(env)
lose "rank lost" KILL rank --ranks 4
lose "interrupted" INT conserva --ranks 2
lose "ended by Slurm" USR1 conserva --ranks 2
# mpirun waits so many seconds before TERM, and again before KILL.
launcher=("${job[@]}" --mca odls_base_sigkill_timeout 5 -n 4)
lose "rank lost under mpirun" KILL rank
lose "mpirun interrupted" INT launcher
lose "mpirun ended" TERM launcher

echo "-- what is missing is told"
launcher=(env CONSERVA_MUMPS=/nowhere)
run --solver mumps --out "$folder/none" && fail "without the program"
grep -q C0526 "$folder/log" || fail "$(cat "$folder/log")"
launcher=("${job[@]}" -n 2)
run --out "$folder/none" && fail "two processes without their solver"
[ "$(grep -c C0529 "$folder/log")" = 1 ] || fail "$(cat "$folder/log")"
echo passed
