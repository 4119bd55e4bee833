#!/bin/sh
# Checks that ./saltus rejects a wrong command line with one sentence and status 2 before it sets anything up, and that its
# help lists every verb of the program and of the pages. Usage: script_test.sh SCRIPT PROGRAM
script=$1 program=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
complain() {
  echo "$*"
  failed=1
}

# refused EXPECTED WORD...: the message contains EXPECTED.
refused() {
  expected=$1
  shift
  said=$("$script" --build-dir "$folder/build" "$@" 2>&1)
  status=$?
  [ "$status" -eq 2 ] || complain "'$*': status $status, not 2"
  [ "$(printf '%s\n' "$said" | wc -l)" -eq 1 ] || complain "'$*': more than one line: $said"
  case $said in
    *"$expected"*) ;;
    *) complain "'$*' says: $said" ;;
  esac
  [ ! -e "$folder/build" ] || complain "'$*': a set-up began"
}
refused "unknown verb 'frobnicate'" frobnicate
refused "unknown verb ''" ""
refused "did you mean 'run'?" rnu push_recovery
refused "did you mean 'list'?" LIST
refused "did you mean 'reproduce'?" reprodce --quick
refused "unknown option '--frob'" --frob list
refused "unknown preset 'fast'" --preset fast test
refused "--packages or --with-peers" setup --frob
refused "there is no table nothing" reproduce nothing
refused "fuzz has no option '--frob'" fuzz --frob
refused "coverage takes names of test programs" coverage qp
refused "docs takes only --out" docs --frob

help=$("$script" help)
verbs=$("$program" help | sed -n '/^Subcommands:/,$s/^  \([a-z]*\) .*/\1/p')
[ -n "$verbs" ] || complain "the program lists no verbs"
for verb in $verbs; do
  printf '%s\n' "$help" | grep -q "^  $verb " || complain "./saltus help does not list '$verb'"
done

# The verbs and options of the README and of the page on the command line exist.
sources=$(dirname "$script")
for page in README.md docs/running.md; do
  for verb in $(grep -o '\./saltus [a-z]*' "$sources/$page" | sed 's/.* //' | sort -u); do
    printf '%s\n' "$help" | grep -q "^  $verb " || complain "$page names the verb '$verb', which ./saltus help does not list"
  done
done
printf '%s\n' "$help" | grep -q -e "^  --no-install " || complain "README.md names --no-install, which ./saltus help does not list"
exit "$failed"
