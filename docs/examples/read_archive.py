"""Reads a session straight from an archive's SQLite file: samples of one trial as a numpy array.

Usage: read_archive.py ARCHIVE [ATTEMPT]        (read-only; the archive may be written meanwhile)
"""

import sqlite3
import sys

import numpy

# A message of samples, CDR little-endian: a header of 4 bytes, then rig, session and trial id of 16 bytes each,
# epoch and first sequence number (u64), whether it was resent (u8, padded), send time (i64), number of samples (u32,
# padded), and the samples of 64 bytes each. Offsets are counted from the end of the header.
FIRST_SAMPLE = 88
SAMPLE = numpy.dtype(
    {
        "names": ["acquisition_ns", "encoder_count", "force_V", "commanded_m", "phase", "flags"],
        "formats": ["<i8", ("<f8", 2), ("<f8", 2), ("<f8", 2), "u1", "u1"],
        "offsets": [0, 8, 24, 40, 56, 57],
        "itemsize": 64,
    }
)


def samples_of(payload, count):
    """The samples of one message. The last one ends without its padding."""
    body = payload[4 + FIRST_SAMPLE :].ljust(count * SAMPLE.itemsize, b"\0")
    return numpy.frombuffer(body, SAMPLE, count)


def trial_of(archive, session, attempt):
    """All samples of a trial, in order and once each."""
    rig, epoch, first, last = archive.execute(
        "SELECT rig_id, epoch, first_sequence, last_sequence FROM trials WHERE session_id = ? AND attempt = ?",
        (session, attempt),
    ).fetchone()
    samples = numpy.zeros(last - first + 1, SAMPLE)
    blocks = archive.execute(
        "SELECT first_sequence, sample_count, payload FROM blocks JOIN streams USING (stream) "
        "WHERE NOT is_auxiliary AND rig_id = ? AND epoch = ? AND first_sequence <= ? AND first_sequence + sample_count > ?",
        (rig, epoch, last, first),
    )
    for begin, count, payload in blocks:
        block = samples_of(payload, count)
        skip = max(first - begin, 0)
        end = min(count, last + 1 - begin)
        samples[begin + skip - first : begin + end - first] = block[skip:end]
    return samples


def main():
    archive = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
    session, subject = archive.execute("SELECT session_id, subject FROM sessions ORDER BY started_at DESC").fetchone()
    attempt = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    samples = trial_of(archive, session, attempt)
    print(f"session {session.hex()}, subject {subject}, trial {attempt}: {len(samples)} samples")
    print(f"first encoder count {samples['encoder_count'][0][0]:.6f}")
    print(f"last force {samples['force_V'][-1][1]:.9f} V")


if __name__ == "__main__":
    main()
