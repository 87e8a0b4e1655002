#include "services/bus/memory/memory_bus.hpp"

#include "services/bus/memory/fabric_state.hpp"
#include "services/bus/topic_check.hpp"

namespace tonus::bus {
namespace {

class MemoryWriter final : public Writer {
 public:
  MemoryWriter(std::shared_ptr<MemoryFabric> fabric, const BusOptions& options, const TopicSpec& topic)
      : fabric_(std::move(fabric)), end_(std::make_shared<WriterEnd>(options.domain, options, topic)) {
    fabric_->state().add(end_);
  }
  ~MemoryWriter() override { fabric_->state().remove(end_); }

  Result<void> write(std::span<const std::byte> payload) override {
    return fabric_->state().write(*end_, payload);
  }
  [[nodiscard]] WriterStatus status() const override { return fabric_->state().status(*end_); }
  bool wait_acknowledged(std::chrono::milliseconds limit) override {
    return fabric_->state().wait_acknowledged(*end_, limit);
  }

 private:
  std::shared_ptr<MemoryFabric> fabric_;
  std::shared_ptr<WriterEnd> end_;
};

class MemoryReader final : public Reader {
 public:
  MemoryReader(std::shared_ptr<MemoryFabric> fabric, const BusOptions& options, const TopicSpec& topic,
               std::shared_ptr<Notifier> notifier)
      : fabric_(std::move(fabric)), end_(std::make_shared<ReaderEnd>(options.domain, options, topic)) {
    end_->notifier = std::move(notifier);
    fabric_->state().add(end_);
  }
  ~MemoryReader() override { fabric_->state().remove(end_); }

  std::size_t take(std::vector<Sample>& out, std::size_t max) override {
    return fabric_->state().take(*end_, out, max);
  }
  [[nodiscard]] ReaderStatus status() const override { return fabric_->state().status(*end_); }

 private:
  std::shared_ptr<MemoryFabric> fabric_;
  std::shared_ptr<ReaderEnd> end_;
};

class MemoryBus final : public Bus {
 public:
  explicit MemoryBus(const BusOptions& options) : options_(options) {}

  Result<std::unique_ptr<Writer>> create_writer(const TopicSpec& topic) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return std::unique_ptr<Writer>(std::make_unique<MemoryWriter>(options_.fabric, options_, topic));
  }

  Result<std::unique_ptr<Reader>> create_reader(const TopicSpec& topic,
                                                std::shared_ptr<Notifier> notifier) override {
    if (auto good = check_topic(topic); !good) return good.error();
    return std::unique_ptr<Reader>(
        std::make_unique<MemoryReader>(options_.fabric, options_, topic, std::move(notifier)));
  }

 private:
  BusOptions options_;
};

}  // namespace

Result<std::unique_ptr<Bus>> create_memory_bus(const BusOptions& options) {
  if (!options.fabric) {
    return fail(ErrorCode::kInvalidArgument, "vendor memory: needs the fabric that its participants share");
  }
  return std::unique_ptr<Bus>(std::make_unique<MemoryBus>(options));
}

}  // namespace tonus::bus
