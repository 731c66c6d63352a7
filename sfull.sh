T=/tmp/files-a/t; cd /tmp/files-a
cat > sfull.toml <<'T'
case = "fcc-small"
[set]
run.frames = 2
packing.size = [8,8,5]
run.end_time = 3e-4
[grid]
load.velocity = [1, 2, 3, 4]
T
mount -t tmpfs -o size=50m tmpfs $T; granwave scan sfull.toml -o $T/s; echo "-> $?"; umount $T
mount -t tmpfs -o size=52m tmpfs $T; granwave scan sfull.toml -o $T/s --jobs 1 2>&1 | grep -v "^ " | tail -5; echo "-> ${PIPESTATUS[0]}"; df -k $T | tail -1
rm -f $T/s/.scan/*; mount -o remount,size=200m $T; granwave scan sfull.toml -o $T/s --jobs 1 --resume 2>&1 | grep -v "^ " | tail -4; umount $T
