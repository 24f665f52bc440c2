#!/bin/sh
# Say what a step does, run it, and print a dot every two seconds until it ends: sh requirements/step.sh WORDS COMMAND...
printf '%s ' "$1"
shift
"$@" &
job=$!
trap 'kill $job 2>/dev/null; exit 130' INT TERM
while sleep 2 && kill -0 $job 2>/dev/null; do printf '.'; done &
dots=$!
wait $job
result=$?
kill $dots 2>/dev/null
echo
exit $result
