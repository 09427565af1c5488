# To be sourced: sums what several test commands count. Each of them closes with a line
# `N passed, N failed[, N skipped]`, and so does print_total.
passed=0 failed=0 skipped=0

# Runs a command that closes with a total, and adds it to ours: add_total NAME COMMAND...
add_total() {
  local name=$1 log total status
  shift
  log=$(mktemp)
  "$@" 2>&1 | tee "$log"
  status=${PIPESTATUS[0]}
  total=$(tail -1 "$log")
  rm -f "$log"
  if [[ $total =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed(,\ ([0-9]+)\ skipped)?$ ]]; then
    ((passed += BASH_REMATCH[1], failed += BASH_REMATCH[2], skipped += ${BASH_REMATCH[4]:-0}))
    if ((status != 0 && BASH_REMATCH[2] == 0)); then ((failed += 1)); fi
  else
    total="did not run to its end (exit code $status)"
    ((failed += 1))
  fi
  printf '%s: %s\n' "$name" "$total"
}

# Runs a command that either holds or not: check NAME COMMAND...
check() {
  local name=$1
  shift
  echo "$name"
  if "$@"; then
    ((passed += 1))
  else
    ((failed += 1))
    echo "$name: failed"
  fi
}

# Fails if anything failed.
print_total() {
  local total="$passed passed, $failed failed"
  ((skipped == 0)) || total+=", $skipped skipped"
  echo "$total"
  ((failed == 0))
}
