"""tonus: how a person's arm resists being moved.

Arrays are NumPy, in SI and in the shoulder frame S (x to the right, y forward, origin at the shoulder); tables are
pandas. The numbers are those of the programs, to the last bit, because the C++ is the same.

    archive = tonus.open("data/archive.sqlite")
    session = archive.session("last")
    session.trials[0].force                     # (rows, 2), N
    session.estimates                           # a row for each condition and method
    tonus.read_bids("dataset").identify()       # as `tonus identify dataset`
    tonus.simulate(seed=1).identify()
    for message in tonus.subscribe("http://127.0.0.1:8765"): ...
"""

from tonus import errors, plot
from tonus._tonus import version as __version__
from tonus.archive import Archive, Auxiliary, Samples, Session, Trial, open
from tonus.errors import (AlreadyExistsError, DataLossError, Error, InternalError, InvalidArgumentError, IoError,
                          NotFoundError, TimeoutError, UnavailableError)
from tonus.estimate import Ellipse, Estimate, Parameters, identify, table
from tonus.live import Message, Subscription, subscribe
from tonus.recording import Dataset, Recording, read_bids, simulate

__all__ = ["AlreadyExistsError", "Archive", "Auxiliary", "DataLossError", "Dataset", "Ellipse", "Error", "Estimate",
           "InternalError", "InvalidArgumentError", "IoError", "Message", "NotFoundError", "Parameters", "Recording",
           "Samples", "Session", "Subscription", "TimeoutError", "Trial", "UnavailableError", "__version__", "errors",
           "identify", "open", "plot", "read_bids", "simulate", "subscribe", "table"]
