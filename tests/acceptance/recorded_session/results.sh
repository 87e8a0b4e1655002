# shellcheck shell=bash
# What the recorded session gives, written to files in a folder. For `check` and `renew`.
#
#   write_results TONUS FOLDER      ($here: the folder of these scripts)

write_results() {
  local tonus=$1 out=$2
  cp "${here:?}/session.sqlite" "$out/session.sqlite"
  "$tonus" identify "$out/session.sqlite" --method all --json "$out/identify.json" >/dev/null
  "$tonus" verify --archive "$out/session.sqlite" --json >"$out/verify.json" 2>/dev/null
  "$tonus" export --archive "$out/session.sqlite" --format csv --out "$out/csv" >/dev/null 2>&1
  "$tonus" export --archive "$out/session.sqlite" --format bids --out "$out/bids" >/dev/null 2>&1
  "$tonus" export --archive "$out/session.sqlite" --format hdf5 --out "$out/session.h5" >/dev/null 2>&1
  rm -f "$out"/session.sqlite*
  sed -i 's/"Version": ".*"/"Version": "of the program"/' "$out/bids/dataset_description.json"

  # Of what is large only the checksum is kept. HDF5 files hold addresses: their content counts, not their bytes.
  if command -v h5dump >/dev/null; then
    h5dump "$out/session.h5" | sed '1s/".*"/"session.h5"/' | sha256sum | sed 's/-$/content of session.h5/' >"$out/checksums"
  else
    : >"$out/checksums"
  fi
  rm "$out/session.h5"
  (cd "$out" && find csv/samples bids -name '*_motion.tsv' -o -path 'csv/samples/*' -type f | LC_ALL=C sort |
    xargs sha256sum) >>"$out/checksums"
  rm -r "$out/csv/samples"
  find "$out/bids" -name '*_motion.tsv' -delete
}
