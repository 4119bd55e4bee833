#include "saltus/robots/control/robot_link.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <thread>

#include "saltus/core/error.hpp"

namespace saltus::robots::control {
namespace {

using namespace std::chrono_literals;

[[noreturn]] void refuse(const std::string& address, const std::string& reason) {
  throw InputError(fmt::format("--link {}: {}", address, reason));
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int number) : number_(number) {}
  ~FileDescriptor() {
    if (number_ >= 0) ::close(number_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

// ---- UDP

class UdpLink final : public RobotLink {
 public:
  UdpLink(const std::string& address, sockaddr_in place, LinkSide side)
      : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    if (socket_.get() < 0) refuse(address, std::strerror(errno));
    if (side == LinkSide::robot) {
      peer_ = place;
      return;
    }
    if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0)
      refuse(address,
             fmt::format("cannot listen there: {}; choose another port", std::strerror(errno)));
  }

  std::span<const std::byte> receive(WallClock::time_point deadline) override {
    for (;;) {
      sender_size_ = sizeof sender_;
      const ssize_t size =
          ::recvfrom(socket_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT | MSG_TRUNC,
                     reinterpret_cast<sockaddr*>(&sender_), &sender_size_);
      // Larger datagrams are cut, which the codec refuses. Errors such as "connection refused"
      // concern an earlier datagram.
      if (size > 0)
        return std::span(buffer_).first(std::min(static_cast<std::size_t>(size), buffer_.size()));
      const auto left = deadline - WallClock::now();
      if (left <= 0ns) return {};
      pollfd wanted{socket_.get(), POLLIN, 0};
      const auto rest = std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::min<WallClock::duration>(left, 500ms));
      const timespec patience{0, static_cast<long>(rest.count())};
      ::ppoll(&wanted, 1, &patience, nullptr);
    }
  }
  void send(std::span<const std::byte> message) override {
    if (peer_.sin_port == 0) return;
    ::sendto(socket_.get(), message.data(), message.size(), MSG_DONTWAIT,
             reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_);
  }
  void accept_sender() override { peer_ = sender_; }
  int port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    ::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }

 private:
  FileDescriptor socket_;
  sockaddr_in sender_{}, peer_{};
  socklen_t sender_size_ = 0;
  std::array<std::byte, most_bytes> buffer_{};
};

std::unique_ptr<RobotLink> open_udp(const std::string& address, LinkSide side) {
  const std::string_view rest = std::string_view(address).substr(4);
  const std::size_t colon = rest.rfind(':');
  const std::string host(colon == std::string_view::npos ? "127.0.0.1" : rest.substr(0, colon));
  const std::string_view digits = colon == std::string_view::npos ? rest : rest.substr(colon + 1);
  int port = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (error != std::errc{} || end != digits.data() + digits.size() || port < 0 || port > 65535 ||
      (port == 0 && side == LinkSide::robot))
    refuse(address, "use udp:PORT or udp:ADDRESS:PORT with a port of at most 65535");
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, host.c_str(), &place.sin_addr) != 1)
    refuse(address, fmt::format("'{}' is not an IPv4 address such as 192.168.0.2", host));
  return std::make_unique<UdpLink>(address, place, side);
}

// ---- shared memory

// One message, which its writer replaces. The count is odd while it writes, so a reader that sees
// the same even count before and after has read a complete message.
struct Slot {
  std::uint32_t count = 0, size = 0;
  std::array<std::uint64_t, RobotLink::most_bytes / 8> words{};
};
struct Segment {
  Slot to_controller, to_robot;
};
static_assert(sizeof(Segment) == 2 * (8 + RobotLink::most_bytes));

template <class Number>
Number get(Number& place) {
  return std::atomic_ref(place).load(std::memory_order_relaxed);
}
template <class Number>
void put(Number& place, Number value) {
  std::atomic_ref(place).store(value, std::memory_order_relaxed);
}

class SharedMemoryLink final : public RobotLink {
 public:
  SharedMemoryLink(const std::string& address, LinkSide side) {
    const std::string name = fmt::format("/{}", address.substr(4));
    if (name.size() < 2 || name.find('/', 1) != std::string::npos)
      refuse(address, "use shm:NAME with a name without a slash");
    const bool creates = side == LinkSide::controller;
    const FileDescriptor& file =
        file_.emplace(::shm_open(name.c_str(), creates ? O_RDWR | O_CREAT : O_RDWR, 0600));
    if (file.get() < 0)
      refuse(address, fmt::format("cannot open /dev/shm{}: {}{}", name, std::strerror(errno),
                                  creates ? "" : "; start `saltus control` first"));
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) refuse(address, std::strerror(errno));
    if (creates) {
      if (status.st_uid != ::geteuid() || (status.st_mode & 077) != 0)
        refuse(address, fmt::format("others can write to /dev/shm{}; remove it", name));
      if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0)
        refuse(address, "another controller uses it; choose another name");
      if (status.st_size == 0) {
        if (const int error = ::posix_fallocate(file.get(), 0, sizeof(Segment)); error != 0)
          refuse(address, std::strerror(error));
        status.st_size = sizeof(Segment);
      }
    }
    if (status.st_size != sizeof(Segment))
      refuse(address, fmt::format("/dev/shm{} has another size; remove it", name));
    void* const memory =
        ::mmap(nullptr, sizeof(Segment), PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0);
    if (memory == MAP_FAILED) refuse(address, std::strerror(errno));
    segment_ = static_cast<Segment*>(memory);
    in_ = creates ? &segment_->to_controller : &segment_->to_robot;
    out_ = creates ? &segment_->to_robot : &segment_->to_controller;
    seen_ = get(in_->count);
  }
  ~SharedMemoryLink() override { ::munmap(segment_, sizeof(Segment)); }
  SharedMemoryLink(const SharedMemoryLink&) = delete;
  SharedMemoryLink& operator=(const SharedMemoryLink&) = delete;

  std::span<const std::byte> receive(WallClock::time_point deadline) override {
    constexpr auto pause = 20us;
    for (;;) {
      const std::uint32_t before = std::atomic_ref(in_->count).load(std::memory_order_acquire);
      if (before % 2 == 0 && before != seen_) {
        const std::size_t size = std::min<std::size_t>(get(in_->size), most_bytes);
        for (std::size_t i = 0; i < (size + 7) / 8; ++i) buffer_[i] = get(in_->words[i]);
        std::atomic_thread_fence(std::memory_order_acquire);
        if (get(in_->count) == before) {
          seen_ = before;
          return std::as_bytes(std::span(buffer_)).first(size);
        }
      }
      const auto left = deadline - WallClock::now();
      if (left <= 0ns) return {};
      std::this_thread::sleep_for(std::min<WallClock::duration>(left, pause));
    }
  }
  void send(std::span<const std::byte> message) override {
    const std::uint32_t count = get(out_->count) | 1U;  // a writer that died may have left it odd
    put(out_->count, count);
    std::atomic_thread_fence(std::memory_order_release);
    put(out_->size, static_cast<std::uint32_t>(message.size()));
    for (std::size_t i = 0; i < message.size(); i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, message.data() + i, std::min<std::size_t>(8, message.size() - i));
      put(out_->words[i / 8], word);
    }
    std::atomic_ref(out_->count).store(count + 1, std::memory_order_release);
  }

 private:
  std::optional<FileDescriptor> file_;  // holds the lock of the controller
  Segment* segment_ = nullptr;
  Slot *in_ = nullptr, *out_ = nullptr;
  std::uint32_t seen_ = 0;
  std::array<std::uint64_t, most_bytes / 8> buffer_{};
};

}  // namespace

std::unique_ptr<RobotLink> open_link(const std::string& address, LinkSide side) {
  if (address.starts_with("udp:")) return open_udp(address, side);
  if (address.starts_with("shm:")) return std::make_unique<SharedMemoryLink>(address, side);
  refuse(address, "use udp:PORT, udp:ADDRESS:PORT or shm:NAME");
}

int port_of(const RobotLink& link) {
  const auto* udp = dynamic_cast<const UdpLink*>(&link);
  return udp != nullptr ? udp->port() : 0;
}

}  // namespace saltus::robots::control
