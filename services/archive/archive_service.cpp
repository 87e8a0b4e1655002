#include "services/archive/archive_service.hpp"

#include <algorithm>
#include <spdlog/spdlog.h>
#include <utility>

#include "services/archive/wire.hpp"

namespace tonus::archive {
namespace {

/// Messages of one topic taken in one step: keeps the steps short under load.
constexpr std::size_t kBatch = 512;

/// Receipts that may wait for the bus; older ones give way, and are given again when the rig or the scheduler
/// asks by repeating what they are for.
constexpr std::size_t kMostUnsent = 4096;

/// Before receipts that the bus refused are tried again.
constexpr Clock::Duration kSendAgain = std::chrono::milliseconds(20);

}  // namespace

ArchiveService::ArchiveService(Ingest& ingest, const Clock& clock, DiskWatch* disk,
                               std::vector<Source> sources, bus::TypedWriter<v1::ArchiveReceipt> receipts,
                               bus::TypedWriter<v1::ArchiveResend> resends)
    : ingest_(ingest),
      clock_(clock),
      disk_(disk),
      sources_(std::move(sources)),
      receipts_(std::move(receipts)),
      resends_(std::move(resends)) {}

Result<std::unique_ptr<ArchiveService>> ArchiveService::create(bus::Bus& bus, Ingest& ingest,
                                                               const Clock& clock,
                                                               std::shared_ptr<bus::Notifier> notifier,
                                                               DiskWatch* disk) {
  TONUS_TRY_ASSIGN(auto receipts, bus::TypedWriter<v1::ArchiveReceipt>::create(bus, topics::kArchiveReceipt));
  TONUS_TRY_ASSIGN(auto resends, bus::TypedWriter<v1::ArchiveResend>::create(bus, topics::kArchiveResend));
  std::vector<Source> sources;
  for (const bus::TopicSpec& topic : topics::kAll) {
    if (!is_kept(topic)) continue;
    TONUS_TRY_ASSIGN(auto reader, bus.create_reader(topic, notifier));
    sources.push_back({topic, std::move(reader)});
  }
  return std::unique_ptr<ArchiveService>(
      new ArchiveService(ingest, clock, disk, std::move(sources), std::move(receipts), std::move(resends)));
}

Clock::TimePoint ArchiveService::step() {
  const bool is_more_there = take_all();
  const Decisions decisions = ingest_.step();
  send(decisions);
  const Clock::TimePoint now = clock_.now();
  Clock::TimePoint due = decisions.due;
  if (disk_ != nullptr) due = std::min(due, disk_->measure_if_due(ingest_.status()));
  if (is_more_there) return now;
  return unsent_.empty() ? due : std::min(due, now + kSendAgain);
}

bool ArchiveService::take_all() {
  bool is_more_there = false;
  for (Source& source : sources_) {
    samples_.clear();
    is_more_there |= source.reader->take(samples_, kBatch) == kBatch;
    taken_ += samples_.size();
    for (const bus::Sample& sample : samples_) {
      if (disk_ != nullptr) disk_->note(source.topic, sample);
      if (auto fed = feed(ingest_, source.topic, sample, clock_.utc_ns()); !fed) {
        ++malformed_;
        spdlog::warn("{}: a message cannot be used: {}", source.topic.name, fed.error().message);
      }
    }
    if (!samples_.empty()) {
      const Clock::TimePoint received{std::chrono::nanoseconds(samples_.back().received_ns)};
      lag_ = std::chrono::duration<double>(clock_.now() - received).count();
    }
  }
  samples_.clear();
  return is_more_there;
}

void ArchiveService::send(const Decisions& decisions) {
  std::vector<v1::ArchiveReceipt> receipts = std::exchange(unsent_, {});
  for (const TrialReceipt& receipt : decisions.trial_receipts) receipts.push_back(to_wire(receipt));
  for (const StreamReceipt& receipt : decisions.stream_receipts) receipts.push_back(to_wire(receipt));
  for (const store::SessionCertificate& certificate : decisions.session_receipts)
    receipts.push_back(to_wire(certificate));
  for (v1::ArchiveReceipt& receipt : receipts) {
    if (const auto sent = receipts_.write(receipt); !sent) {
      spdlog::warn("a receipt waits: {}", sent.error().message);
      unsent_.push_back(std::move(receipt));
    }
  }
  if (unsent_.size() > kMostUnsent) {
    spdlog::error("{} receipts could not be sent", unsent_.size() - kMostUnsent);
    unsent_.erase(unsent_.begin(), unsent_.end() - static_cast<std::ptrdiff_t>(kMostUnsent));
  }
  // A request that is not sent is made again when it is due again.
  for (const ResendRequest& request : decisions.resends) {
    spdlog::info("asks for samples {} to {} of epoch {} again", request.range.first, request.range.end - 1,
                 request.stream.epoch);
    if (const auto sent = resends_.write(to_wire(request)); !sent) {
      spdlog::warn("a request to send again waits: {}", sent.error().message);
    }
  }
}

std::string ArchiveService::why_not_ready() const {
  if (std::string failure = ingest_.status().failure; !failure.empty()) return failure;
  if (disk_ != nullptr) {
    if (std::string refusal = disk_->refusal(); !refusal.empty()) return refusal;
  }
  for (const Source& source : sources_) {
    if (source.topic.name != topics::kRigSamples.spec.name) continue;
    if (source.reader->status().matched_writers == 0) return "waits for a rig";
  }
  return {};
}

std::uint64_t ArchiveService::dropped() const {
  std::uint64_t dropped = malformed_ + ingest_.status().lost_messages;
  for (const Source& source : sources_) {
    const bus::ReaderStatus status = source.reader->status();
    dropped += status.malformed;
  }
  return dropped;
}

}  // namespace tonus::archive
