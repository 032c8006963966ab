#!/usr/bin/env bash
# Builds conserva-mumps into target/release, beside the program, or into the folder that is given.
# Debian: apt-get install libmumps-dev libopenmpi-dev openmpi-bin
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
folder="${1:-$here/../../target/release}"
mkdir -p "$folder"
"${MPICC:-mpicc}" -std=gnu11 -O2 -Wall -Wextra -Werror -o "$folder/conserva-mumps" "$here/conserva-mumps.c" \
    ${MUMPS_FLAGS:--ldmumps -lmumps_common} -ldl -lm
echo "built $folder/conserva-mumps"
