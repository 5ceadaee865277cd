#!/usr/bin/env bash
# old_driver_check.sh BUILD: with a driver that is too old, a GPU asked for by name is refused in one line with exit code 4, and the tests
# that need one are skipped; what may choose goes on with the CPU.
set -uo pipefail
build=$1
export LD_LIBRARY_PATH=$build/tests/old-driver
said=$("$build/bin/rve-farm" bench --backend cuda --windows 1 2>&1 >/dev/null)
code=$?
[ $code = 4 ] || { echo "exit code $code, not 4: $said"; exit 1; }
[ "$(wc -l <<<"$said")" = 1 ] || { echo "more than one line: $said"; exit 1; }
grep -q 'error: .*the NVIDIA driver is too old: it is for CUDA 11.4' <<<"$said" || { echo "another cause: $said"; exit 1; }
"$build/bin/test-gpu" >/dev/null
[ $? = 77 ] || { echo "the tests that need a GPU were not skipped"; exit 1; }
