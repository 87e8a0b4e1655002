#include "tests/fault/simulator/network.hpp"

#include <algorithm>
#include <utility>

#include "services/bus/payload.hpp"

namespace tonus::simulator {
namespace {

constexpr std::chrono::seconds kLease{3};

}  // namespace

struct Network::Link {
  std::shared_ptr<Writing> writer;
  std::shared_ptr<Reading> reader;
  bool is_matched = false;
  struct Underway {
    Time due;
    bus::Sample sample;
  };
  std::deque<Underway> underway;
  Time last_due{};
};

struct Network::Writing {
  Writing(std::shared_ptr<Life> owner, const bus::TopicSpec& spec) : life(std::move(owner)), topic(spec) {}
  std::shared_ptr<Life> life;
  bus::OwnedTopic topic;
  bus::SampleQueue history{bus::WriterEnd::late_reader_qos(topic.qos)};
  bus::WriterStatus status;
  std::vector<std::shared_ptr<Link>> links;
};

struct Network::Reading {
  Reading(std::shared_ptr<Life> owner, const bus::TopicSpec& spec, std::shared_ptr<bus::Notifier> told)
      : life(std::move(owner)), topic(spec), notifier(std::move(told)) {}
  std::shared_ptr<Life> life;
  bus::OwnedTopic topic;
  std::shared_ptr<bus::Notifier> notifier;
  bus::SampleQueue queue{topic.qos};
  bus::ReaderStatus status;
  std::vector<std::weak_ptr<Link>> links;
};

namespace {

class SimulatedWriter final : public bus::Writer {
 public:
  SimulatedWriter(Network& network, std::shared_ptr<Network::Writing> end)
      : network_(network), end_(std::move(end)) {}
  ~SimulatedWriter() override { network_.remove(*end_); }

  Result<void> write(std::span<const std::byte> payload) override { return network_.write(*end_, payload); }
  [[nodiscard]] bus::WriterStatus status() const override {
    bus::WriterStatus status = end_->status;
    status.matched_readers = static_cast<int>(std::count_if(
        end_->links.begin(), end_->links.end(), [](const auto& link) { return link->is_matched; }));
    return status;
  }
  bool wait_acknowledged(std::chrono::milliseconds limit) override {
    const bool is_there = std::all_of(end_->links.begin(), end_->links.end(), [](const auto& link) {
      return !link->is_matched || link->underway.empty();
    });
    if (!is_there) end_->life->clock.wait(limit);
    return is_there;
  }

 private:
  Network& network_;
  std::shared_ptr<Network::Writing> end_;
};

class SimulatedReader final : public bus::Reader {
 public:
  SimulatedReader(Network& network, std::shared_ptr<Network::Reading> end)
      : network_(network), end_(std::move(end)) {}
  ~SimulatedReader() override { network_.remove(*end_); }

  std::size_t take(std::vector<bus::Sample>& out, std::size_t max) override {
    const std::size_t count = std::min(max, end_->queue.samples().size());
    for (std::size_t i = 0; i < count; ++i) {
      out.push_back(end_->queue.samples().front());
      end_->queue.pop_front();
    }
    end_->status.received += count;
    return count;
  }
  [[nodiscard]] bus::ReaderStatus status() const override {
    bus::ReaderStatus status = end_->status;
    for (const auto& each : end_->links) {
      const auto link = each.lock();
      if (!link || !link->is_matched) continue;
      ++status.matched_writers;
      if (!link->writer->life->is_dead) ++status.alive_writers;
    }
    return status;
  }

 private:
  Network& network_;
  std::shared_ptr<Network::Reading> end_;
};

class SimulatedBus final : public bus::Bus {
 public:
  SimulatedBus(Network& network, std::shared_ptr<Life> life) : network_(network), life_(std::move(life)) {}
  Result<std::unique_ptr<bus::Writer>> create_writer(const bus::TopicSpec& topic) override {
    return std::unique_ptr<bus::Writer>(
        std::make_unique<SimulatedWriter>(network_, network_.add_writer(life_, topic)));
  }
  Result<std::unique_ptr<bus::Reader>> create_reader(const bus::TopicSpec& topic,
                                                     std::shared_ptr<bus::Notifier> notifier) override {
    return std::unique_ptr<bus::Reader>(
        std::make_unique<SimulatedReader>(network_, network_.add_reader(life_, topic, std::move(notifier))));
  }

 private:
  Network& network_;
  std::shared_ptr<Life> life_;
};

}  // namespace

Network::~Network() {
  for (const auto& writer : writers_) writer->links.clear();  // each link holds its writer
}

std::unique_ptr<bus::Bus> Network::join(std::shared_ptr<Life> life) {
  return std::make_unique<SimulatedBus>(*this, std::move(life));
}

Clock::Duration Network::drawn(double longest) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * random_.between(0.0, longest)));
}

void Network::schedule(Time due, Change change, const std::shared_ptr<Link>& link) {
  events_.push({due, ++number_, change, link});
}

std::shared_ptr<Network::Writing> Network::add_writer(std::shared_ptr<Life> life,
                                                      const bus::TopicSpec& topic) {
  auto end = std::make_shared<Writing>(std::move(life), topic);
  writers_.push_back(end);
  for (const auto& reader : readers_) link(end, reader);
  return end;
}

std::shared_ptr<Network::Reading> Network::add_reader(std::shared_ptr<Life> life, const bus::TopicSpec& topic,
                                                      std::shared_ptr<bus::Notifier> notifier) {
  auto end = std::make_shared<Reading>(std::move(life), topic, std::move(notifier));
  readers_.push_back(end);
  for (const auto& writer : writers_) link(writer, end);
  return end;
}

void Network::link(const std::shared_ptr<Writing>& writer, const std::shared_ptr<Reading>& reader) {
  if (writer->topic.name != reader->topic.name || writer->life->is_dead || reader->life->is_dead) return;
  auto made = std::make_shared<Link>();
  made->writer = writer;
  made->reader = reader;
  writer->links.push_back(made);
  reader->links.push_back(made);
  const bool is_own = writer->life == reader->life;
  schedule(std::max(now_, cut_until(*made)) + (is_own ? Clock::Duration{} : drawn(options_.discovery)),
           Change::kMeet, made);
}

void Network::meet(const std::shared_ptr<Link>& link) {
  if (link->is_matched || link->writer->life->is_dead || link->reader->life->is_dead) return;
  if (const Time until = cut_until(*link); until > now_)
    return schedule(until + drawn(options_.discovery), Change::kMeet, link);
  link->is_matched = true;
  if (link->writer->topic.qos.durability == bus::Durability::kTransientLocal) {
    for (const bus::Sample& sample : link->writer->history.samples()) send(link, sample);
  }
  wake(*link->reader);
}

void Network::part(Link& link) {
  link.is_matched = false;
  link.underway.clear();
  wake(*link.reader);
}

Time Network::cut_until(const Link& link) const {
  if (link.writer->life == link.reader->life) return {};
  Time until{};
  for (const auto& program : {link.writer->life->program, link.reader->life->program}) {
    if (const auto cut = cuts_.find(program); cut != cuts_.end()) until = std::max(until, cut->second);
  }
  return until;
}

void Network::cut(const std::string& program, Time until) {
  cuts_[program] = until;
  if (until - now_ < kLease) return;
  for (const auto& writer : writers_) {
    for (const auto& link : writer->links) {
      if (cut_until(*link) <= now_) continue;
      schedule(now_ + kLease, Change::kPart, link);
      schedule(until + drawn(options_.discovery), Change::kMeet, link);
    }
  }
}

void Network::bury(const Life& life) {
  has_dead_ = true;
  for (const auto& writer : writers_) {
    for (const auto& link : writer->links) {
      if (link->writer->life.get() == &life || link->reader->life.get() == &life)
        schedule(now_ + kLease, Change::kPart, link);
    }
  }
}

// An end that goes in order says so at once; of a dead one nobody knows yet.
void Network::remove(Writing& end) {
  if (end.life->is_dead) return;
  for (const auto& link : end.links) part(*link);
  end.links.clear();
  std::erase_if(writers_, [&end](const auto& each) { return each.get() == &end; });
}

void Network::remove(Reading& end) {
  if (end.life->is_dead) return;
  for (const auto& each : end.links) {
    const auto link = each.lock();
    if (!link) continue;
    part(*link);
    std::erase(link->writer->links, link);
  }
  std::erase_if(readers_, [&end](const auto& each) { return each.get() == &end; });
}

Result<void> Network::write(Writing& end, std::span<const std::byte> payload) {
  if (end.life->is_dead) return {};
  if (auto good = bus::check_payload(payload, end.topic.max_payload_bytes); !good) {
    ++end.status.refused;
    return good;
  }
  const bus::Qos& qos = end.topic.qos;
  const auto is_full = [&qos](const auto& link) {
    return link->is_matched && link->underway.size() + link->reader->queue.samples().size() >=
                                   static_cast<std::size_t>(qos.depth);
  };
  if (qos.reliable && qos.history == bus::History::kKeepAll &&
      std::any_of(end.links.begin(), end.links.end(), is_full)) {
    end.life->clock.wait(qos.max_blocking);
    ++end.status.refused;
    return fail(ErrorCode::kTimeout, "topic '" + end.topic.name + "': its history stayed full");
  }
  const bool is_last = end.life->dies_now();
  if (is_last && random_.chance(0.5)) throw Died{};
  witness_(*end.life, end.topic.name, payload);
  bus::Sample sample;
  sample.payload = std::make_shared<const bus::Payload>(bus::padded_copy(payload));
  sample.key = bus::payload_key(payload);
  sample.source_timestamp_ns = static_cast<std::int64_t>(end.life->clock.utc_ns());
  ++end.status.written;
  if (qos.durability == bus::Durability::kTransientLocal) end.history.push(sample);
  for (const auto& link : end.links) {
    if (link->is_matched && (qos.reliable || !random_.chance(options_.loss))) send(link, sample);
  }
  if (is_last) throw Died{};
  return {};
}

void Network::send(const std::shared_ptr<Link>& link, const bus::Sample& sample) {
  const bool is_slow = random_.chance(options_.slow_share);
  const Time sent = std::max(now_, link->writer->life->clock.now());
  const Time due =
      std::max(link->last_due, sent + std::chrono::microseconds(30) + drawn(is_slow ? options_.slow : 0.001));
  link->last_due = due;
  link->underway.push_back({due, sample});
  schedule(due, Change::kArrive, link);
}

void Network::arrive(const std::shared_ptr<Link>& link) {
  if (link->underway.empty() || link->underway.front().due > now_ || link->reader->life->is_dead) return;
  if (const Time until = cut_until(*link); until > now_) {
    if (link->writer->topic.qos.reliable) return schedule(until + drawn(0.01), Change::kArrive, link);
    link->underway.pop_front();
    return;
  }
  Reading& reader = *link->reader;
  while (!link->underway.empty() && link->underway.front().due <= now_) {
    bus::Sample sample = std::move(link->underway.front().sample);
    link->underway.pop_front();
    sample.received_ns = reader.life->clock.now().time_since_epoch().count();
    reader.queue.push(sample);
  }
  wake(reader);
}

void Network::wake(Reading& reader) {
  if (!reader.notifier || reader.life->is_dead) return;
  for (Task& task : reader.life->tasks) {
    if (task.notifier == reader.notifier) task.due = std::min(task.due, now_ + drawn(0.0002));
  }
}

void Network::deliver() {
  while (!events_.empty() && events_.top().due <= now_) {
    const Event event = events_.top();
    events_.pop();
    const auto link = event.link.lock();
    if (!link) continue;
    if (event.change == Change::kMeet) {
      meet(link);
    } else if (event.change == Change::kArrive) {
      arrive(link);
    } else {
      const bool is_over = link->writer->life->is_dead || link->reader->life->is_dead;
      if (is_over || cut_until(*link) > now_) part(*link);
    }
  }
  if (has_dead_) forget_dead();
}

// What nobody is matched with any more.
void Network::forget_dead() {
  const auto is_matched = [](const auto& link) { return link->is_matched; };
  std::erase_if(writers_, [&](const auto& end) {
    if (!end->life->is_dead || std::any_of(end->links.begin(), end->links.end(), is_matched)) return false;
    end->links.clear();  // each link holds its writer
    return true;
  });
  std::erase_if(readers_, [](const auto& end) {
    if (!end->life->is_dead) return false;
    std::erase_if(end->links, [](const auto& each) { return each.expired(); });
    const auto is_kept = [](const auto& each) { return each.lock()->is_matched; };
    if (std::any_of(end->links.begin(), end->links.end(), is_kept)) return false;
    for (const auto& each : end->links) {
      const auto link = each.lock();
      std::erase(link->writer->links, link);
    }
    return true;
  });
  const auto is_dead = [](const auto& end) { return end->life->is_dead; };
  has_dead_ = std::any_of(writers_.begin(), writers_.end(), is_dead) ||
              std::any_of(readers_.begin(), readers_.end(), is_dead);
}

}  // namespace tonus::simulator
