#!/bin/bash
# A run on a cluster with Slurm whose linear systems are solved by MUMPS on all tasks of the job:
#
#   sbatch --nodes=4 --ntasks=64 slurm.sh script.rhai [FOLDER] [ARGUMENTS]
#
# Two minutes before the time limit Slurm sends USR1: the run ends with a checkpoint. Submitted again, the same command goes on from it.
# Conserva runs in the batch shell and starts the ranks itself, so that a lost rank ends the ranks, not the program that keeps the results.
#SBATCH --job-name=conserva
#SBATCH --signal=B:USR1@120
#SBATCH --open-mode=append
set -eu
script=$1
folder=${2:-out/$(basename "$script" .rhai)}
shift $(($# < 2 ? $# : 2))
# One thread per rank of MUMPS; assembly and contact are on the first node and use the cores that Slurm gives to a task.
solver=(--solver mumps --ranks "${SLURM_NTASKS:-1}" --threads "${SLURM_CPUS_PER_TASK:-1}")
if [ -n "$(ls "$folder/checkpoints"/*.checkpoint 2>/dev/null)" ]; then
    exec conserva resume "$folder" --quiet "${solver[@]}"
fi
exec conserva run "$script" --quiet --out "$folder" "${solver[@]}" "$@"
