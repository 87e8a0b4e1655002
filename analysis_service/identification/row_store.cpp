#include "analysis_service/identification/row_store.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace tonus::identification {

RowStore::Runs::const_iterator RowStore::run_reaching(std::uint64_t sequence) const {
  auto run = runs_.upper_bound(sequence);
  if (run != runs_.begin() && end_of(*std::prev(run)) > sequence) --run;
  return run;
}

std::size_t RowStore::add(std::uint64_t first_sequence, std::span<const Row> rows) {
  const std::size_t before = rows_;
  if (rows.size() > std::numeric_limits<std::uint64_t>::max() - first_sequence)
    return 0;  // numbers cannot be
  const std::uint64_t end = first_sequence + rows.size();
  std::uint64_t next = first_sequence;
  while (next < end) {
    const auto run = run_reaching(next);
    if (run != runs_.end() && run->first <= next) {  // a repeat
      next = end_of(*run);
      continue;
    }
    const std::uint64_t stop = run == runs_.end() ? end : std::min(end, run->first);
    insert_run(next, rows.subspan(next - first_sequence, stop - next));
    next = stop;
  }
  return rows_ - before;
}

void RowStore::insert_run(std::uint64_t first_sequence, std::span<const Row> rows) {
  rows_ += rows.size();
  auto after = runs_.upper_bound(first_sequence);
  Runs::iterator run;
  if (after != runs_.begin() && end_of(*std::prev(after)) == first_sequence) {
    run = std::prev(after);
    run->second.insert(run->second.end(), rows.begin(), rows.end());
  } else {
    run = runs_.emplace_hint(after, first_sequence, std::vector<Row>(rows.begin(), rows.end()));
  }
  if (after != runs_.end() && after->first == end_of(*run)) {
    run->second.insert(run->second.end(), after->second.begin(), after->second.end());
    runs_.erase(after);
  }
}

void RowStore::erase(const SequenceRange& range) {
  if (range.is_empty()) return;
  for (auto run = run_reaching(range.first); run != runs_.end() && run->first < range.end;
       run = run_reaching(range.first)) {
    const auto node = runs_.extract(run);
    const std::uint64_t first = node.key();
    const std::span<const Row> rows = node.mapped();
    rows_ -= rows.size();
    if (first < range.first) insert_run(first, rows.first(range.first - first));
    if (range.end - first < rows.size()) insert_run(range.end, rows.subspan(range.end - first));
  }
}

std::vector<SequenceRange> RowStore::missing(const SequenceRange& range) const {
  std::vector<SequenceRange> gaps;
  std::uint64_t next = range.first;
  for (auto run = run_reaching(range.first); next < range.end; ++run) {
    if (run == runs_.end() || run->first >= range.end) {
      gaps.push_back({next, range.end});
      break;
    }
    if (run->first > next) gaps.push_back({next, run->first});
    next = end_of(*run);
  }
  return gaps;
}

bool RowStore::holds(const SequenceRange& range) const {
  const auto run = run_reaching(range.first);
  return run != runs_.end() && run->first <= range.first && end_of(*run) >= range.end;
}

std::span<const Row> RowStore::from(std::uint64_t sequence) const {
  const auto run = run_reaching(sequence);
  if (run == runs_.end() || run->first > sequence) return {};
  return std::span<const Row>(run->second).subspan(sequence - run->first);
}

std::vector<Row> RowStore::copy(const SequenceRange& range) const {
  Row placeholder;
  placeholder.is_missing = true;
  std::vector<Row> rows(range.count(), placeholder);
  for (auto run = run_reaching(range.first); run != runs_.end() && run->first < range.end; ++run) {
    const std::uint64_t first = std::max(run->first, range.first);
    const std::uint64_t end = std::min(end_of(*run), range.end);
    std::copy_n(run->second.begin() + static_cast<std::ptrdiff_t>(first - run->first), end - first,
                rows.begin() + static_cast<std::ptrdiff_t>(first - range.first));
  }
  return rows;
}

std::vector<SequenceRange> RowStore::runs() const {
  std::vector<SequenceRange> all;
  for (const auto& run : runs_) all.push_back({run.first, end_of(run)});
  return all;
}

}  // namespace tonus::identification
