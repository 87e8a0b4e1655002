#include "tests/bench/latency/round_trip.hpp"

#include <arpa/inet.h>
#include <cstdio>
#include <cstring>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "idl/topics.hpp"

namespace tonus::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr bus::TopicSpec kThere{"bench/there", "tonus::v1::SampleBlock", topics::qos::kStream, 32768};
constexpr bus::TopicSpec kBack{"bench/back", "tonus::v1::Estimate", topics::qos::kLive, 60000};
constexpr std::size_t kNumberAt = 20;  // behind header and key
constexpr std::chrono::milliseconds kLost{200};

bus::Payload message(std::size_t bytes, std::uint64_t number) {
  bus::Payload payload(std::max(bytes, kNumberAt + sizeof number));
  payload[1] = std::byte{1};  // plain CDR, little endian
  std::memcpy(payload.data() + kNumberAt, &number, sizeof number);
  return payload;
}

std::uint64_t number_of(const bus::Payload& payload) {
  std::uint64_t number = 0;
  if (payload.size() >= kNumberAt + sizeof number)
    std::memcpy(&number, payload.data() + kNumberAt, sizeof number);
  return number;
}

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

}  // namespace

int echo_on_bus(const bus::BusOptions& options, const TripSettings& settings) {
  const auto notifier = std::make_shared<bus::Notifier>();
  auto bus = bus::create_bus(options);
  if (!bus) return 1;
  auto reader = (*bus)->create_reader(kThere, notifier);
  auto writer = (*bus)->create_writer(kBack);
  if (!reader || !writer) return 1;
  std::vector<bus::Sample> samples;
  while (true) {
    (void)notifier->wait_until(Clock::time_point::max());
    samples.clear();
    (*reader)->take(samples);
    for (const auto& sample : samples)
      (void)(*writer)->write(message(settings.back, number_of(*sample.payload)));
  }
}

int echo_on_udp(const TripSettings& settings) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in own = loopback(0);
  socklen_t size = sizeof own;
  if (::bind(descriptor, reinterpret_cast<sockaddr*>(&own), size) != 0) return 1;
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &size);
  std::printf("%u\n", static_cast<unsigned>(ntohs(own.sin_port)));
  std::fflush(stdout);
  std::vector<char> buffer(65536);
  while (true) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    if (::recvfrom(descriptor, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &length) >
        0)
      ::sendto(descriptor, buffer.data(), settings.back, 0, reinterpret_cast<sockaddr*>(&from), length);
  }
}

std::vector<double> bus_trips(const bus::BusOptions& options, const TripSettings& settings,
                              const std::atomic<bool>& is_over) {
  std::vector<double> trips;
  const auto notifier = std::make_shared<bus::Notifier>();
  auto bus = bus::create_bus(options);
  if (!bus) return trips;
  auto reader = (*bus)->create_reader(kBack, notifier);
  auto writer = (*bus)->create_writer(kThere);
  if (!reader || !writer) return trips;
  std::vector<bus::Sample> samples;
  auto due = Clock::now();
  for (std::uint64_t number = 1; !is_over; ++number, due += settings.period) {
    std::this_thread::sleep_until(due);
    if ((*writer)->status().matched_readers == 0 || (*reader)->status().matched_writers == 0) continue;
    const auto begin = Clock::now();
    if (!(*writer)->write(message(settings.there, number))) continue;
    bool is_back = false;
    while (!is_back && Clock::now() < begin + kLost) {
      (void)notifier->wait_until(begin + kLost);
      samples.clear();
      (*reader)->take(samples);
      for (const auto& sample : samples) is_back = is_back || number_of(*sample.payload) == number;
    }
    if (is_back) trips.push_back(ms_since(begin));
  }
  return trips;
}

std::vector<double> udp_trips(const TripSettings& settings, const std::atomic<bool>& is_over) {
  std::vector<double> trips;
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM, 0);
  const sockaddr_in to = loopback(settings.port);
  const timeval limit{0, 200'000};
  ::setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  std::vector<char> buffer(65536);
  for (auto due = Clock::now(); !is_over; due += settings.period) {
    std::this_thread::sleep_until(due);
    const auto begin = Clock::now();
    if (::sendto(descriptor, buffer.data(), settings.there, 0, reinterpret_cast<const sockaddr*>(&to),
                 sizeof to) < 0)
      continue;
    if (::recv(descriptor, buffer.data(), buffer.size(), 0) > 0) trips.push_back(ms_since(begin));
  }
  ::close(descriptor);
  return trips;
}

}  // namespace tonus::bench
