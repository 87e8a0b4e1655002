"""Reads a session that `tonus export --format hdf5` wrote.

Usage: read_hdf5.py SESSION.h5
"""

import sys

import h5py


def main():
    with h5py.File(sys.argv[1], "r") as session:
        print(f"session {session.attrs['session_id']}, subject {session.attrs['subject']}")
        trial = session["trials/0001"]
        force = trial["force"]
        print(f"trial 1: {len(trial['time'])} samples, force in {force.attrs['units']}")
        for estimate in session["estimates"].values():
            stiffness = estimate["K"]
            print(f"{estimate.attrs['posture']}: K(1,1) = {stiffness[0][0]!r} {stiffness.attrs['units']}")


if __name__ == "__main__":
    main()
