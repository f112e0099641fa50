#!/usr/bin/env bash
# A cluster of one node on this machine: munge, slurmctld and slurmd, on localhost only, in a folder
# of their own. Runs the array of shards and the merge of docs/sweeps.md through it, once with a shard
# that is preempted, and holds the files against those of one process.
#
#     tests/slurm.sh [PROGRAM]
#
# Installs the Debian packages where apt-get may. Where Slurm cannot start, says so and ends well.
set -euo pipefail
program=$(realpath "${1:-$(dirname "$0")/../target/release/hertzchain}")
[[ -x $program ]] || { echo "no program at $program: cargo build --release" >&2; exit 2; }

skip() { echo "SKIPPED: $*"; exit 0; }

have() { command -v munged && command -v slurmctld && command -v slurmd && command -v sbatch; }
PATH=$PATH:/usr/sbin:/sbin
if ! have >/dev/null; then
    (apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        slurmctld slurmd slurm-client munge) >/dev/null 2>&1 \
        || skip "no Slurm here, and apt-get may not install slurmctld, slurmd, slurm-client, munge"
fi

folder=$(mktemp -d)
started=()
finish() {
    for id in "${started[@]}"; do kill "$id" 2>/dev/null || true; done
    wait
    rm -rf "$folder"
}
trap finish EXIT

name=$(hostname -s)
port=$((20000 + $$ % 20000))
mkdir "$folder"/{munge,state,spool,work}
chmod 755 "$folder"
dd if=/dev/urandom of="$folder/munge/key" bs=128 count=1 status=none
chmod 400 "$folder/munge/key"
cat >"$folder/slurm.conf" <<END
ClusterName=one
SlurmctldHost=$name(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmctldParameters=enable_configless
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
KillWait=5
NodeName=$name NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$name Default=YES State=UP
END
export SLURM_CONF=$folder/slurm.conf

munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" \
    >"$folder/munge/said" 2>&1 &
started+=($!)
sleep 1
slurmctld -D >"$folder/slurmctld.said" 2>&1 &
started+=($!)
slurmd -D >"$folder/slurmd.said" 2>&1 &
started+=($!)
for _ in $(seq 60); do
    [[ $(sinfo -h -o %T 2>/dev/null) == idle ]] && break
    sleep 0.5
done
if [[ $(sinfo -h -o %T 2>/dev/null) != idle ]]; then
    tail -n 3 "$folder"/*.log "$folder"/*.said "$folder/munge/log" >&2 || true
    skip "Slurm does not start here"
fi

cd "$folder/work"
study="study lifetimes --epsilons 0.3,0.35,0.4 --rhos 5,7,10 --sites 30 --until 12"
# shellcheck disable=SC2086
"$program" $study --out whole >whole.txt 2>/dev/null

# The lines of the guide.
id=$(sbatch --parsable --array=1-4 --output=shard-%a.txt \
    --wrap "$program $study --out map --shard \$SLURM_ARRAY_TASK_ID/4")
sbatch --quiet --wait --dependency="afterany:$id" --output=merge.txt --wrap "$program $study --out map"
diff -r whole map
[[ $(cat shard-*.txt | grep -c '^shard ') == 4 ]]
echo "an array of four shards and its merge: the files of one process"

# A shard that is preempted keeps what it has, and is run again.
long="wave tw-q45 --zeta 0.01 --seeds 200 --until 8 --samples-per-period 4 --tol 1e-6"
# shellcheck disable=SC2086
"$program" $long --out ensemble >/dev/null 2>&1
id=$(sbatch --parsable --output=taken.txt --wrap "exec $program $long --out parts --shard 1/2")
for _ in $(seq 200); do
    [[ $(cat parts/*.store* 2>/dev/null | wc -l) -gt 3 ]] && break
    sleep 0.05
done
scancel --signal=TERM --full "$id"
while [[ -n $(squeue -h -j "$id" 2>/dev/null) ]]; do sleep 0.2; done
kept=$(cat parts/*.store* | wc -l)
id=$(sbatch --parsable --array=1-2 --output=again-%a.txt --wrap "$program $long --out parts --shard \$SLURM_ARRAY_TASK_ID/2")
sbatch --quiet --wait --dependency="afterany:$id" --output=joined.txt --wrap "$program $long --out parts"
diff -r -x wave.json ensemble parts
echo "a shard that was preempted after $((kept - 1)) points: run again, the files of one process"
