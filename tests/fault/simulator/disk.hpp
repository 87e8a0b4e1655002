#pragma once

#include "tests/fault/simulator/life.hpp"

namespace tonus::simulator {

/// What is wrong with a program's disk.
struct Disk {
  bool is_full = false;  ///< No file grows; what is overwritten in place is.
};

/// For as long as one lives, what is written to files is written by this life, to this disk. The program that
/// links this has its own write(), pwrite(), fsync() and fdatasync(): a life may die in the middle of a
/// write, and nothing is waited for. Not for use by several threads.
class WritesOf {
 public:
  WritesOf(Life& life, const Disk& disk);
  ~WritesOf();
  WritesOf(const WritesOf&) = delete;
  WritesOf& operator=(const WritesOf&) = delete;
};

}  // namespace tonus::simulator
