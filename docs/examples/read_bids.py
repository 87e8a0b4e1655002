"""Reads a BIDS Motion dataset that `tonus export --format bids` wrote, with numpy alone.

Usage: read_bids.py DATASET
"""

import csv
import glob
import sys

import numpy


def read_run(stem, events_file):
    with open(stem + "_channels.tsv") as file:
        names = [row["name"] for row in csv.DictReader(file, delimiter="\t")]
    motion = numpy.genfromtxt(stem + "_motion.tsv", delimiter="\t", missing_values="n/a", names=names)
    with open(events_file) as file:
        events = list(csv.DictReader(file, delimiter="\t"))
    return motion, events


def main():
    for motion_file in sorted(glob.glob(sys.argv[1] + "/sub-*/**/*_motion.tsv", recursive=True)):
        stem = motion_file.removesuffix("_motion.tsv")
        events_file = stem.replace("_tracksys-manipulandum", "") + "_events.tsv"
        motion, events = read_run(stem, events_file)
        valid = [event for event in events if event["valid"] == "true"]
        print(f"{stem.split('/')[-1]}: {len(motion)} rows, {len(valid)} of {len(events)} perturbations count")


if __name__ == "__main__":
    main()
