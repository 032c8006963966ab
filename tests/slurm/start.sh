#!/bin/sh
# Starts a Slurm of two nodes on this machine in a scratch folder, without systemd and munge, for tests of the engine.
#
#   sh start.sh FOLDER PORT      writes FOLDER/slurm.conf and starts the daemons; their process numbers are in FOLDER/pids
#
# Needs the programs slurmctld, slurmd, sbatch and squeue (Debian: slurmctld, slurmd, slurm-client) and the rights to start them (root).
# Leaves with 77 where they are missing. Kill the processes in FOLDER/pids to stop it.
set -eu
folder=$1
port=$2
for program in slurmctld slurmd sbatch squeue scontrol; do
    PATH=$PATH:/usr/sbin command -v "$program" >/dev/null || { echo "$program is not installed" >&2; exit 77; }
done
PATH=$PATH:/usr/sbin
host=$(hostname -s)
mkdir -p "$folder/state" "$folder/spool-one" "$folder/spool-two"
cat > "$folder/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,bf_interval=1
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool-%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd-%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd-%n.log
SlurmctldPort=$port
MpiDefault=none
ReturnToService=2
KillWait=5
MinJobAge=2
MaxArraySize=11
NodeName=one NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 RealMemory=1000 State=UNKNOWN
NodeName=two NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes=one,two Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$folder/slurm.conf"
slurmctld -D >/dev/null 2>&1 &
echo $! > "$folder/pids"
for node in one two; do
    slurmd -D -N "$node" >/dev/null 2>&1 &
    echo $! >> "$folder/pids"
done
# Nodes need a moment to be known.
for _ in $(seq 100); do
    if [ "$(sinfo --Node --noheader --format=%T 2>/dev/null | grep -c idle)" = 2 ]; then
        exit 0
    fi
    sleep 0.2
done
echo "the nodes did not come up:" >&2
sinfo --Node --long >&2 || true
tail -n 5 "$folder"/*.log >&2
exit 1
