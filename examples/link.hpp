// The common part of link_robot.cpp and link_controller.cpp: the model, two messages, and a UDP
// socket.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <netinet/in.h>
#include <saltus/saltus.hpp>

using namespace saltus;

constexpr double period = 0.02;  // s

struct Cart {  // x = (position m, speed m/s), u = force per mass, m/s^2
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 0.2 * x[1]};
  }
};

// Plain bytes, because both processes run on one machine; other machines may need a byte order.
struct Measurement {
  std::uint32_t kind = 0x4d454131;  // identifies our messages
  std::int32_t number = 0;          // number of the period; negative: the robot has finished
  double time = 0.0;                // time of the measurement on the robot's clock, s
  double state[2] = {0.0, 0.0};
};
struct Command {
  std::uint32_t kind = 0x434d4431;
  std::int32_t number = 0;      // number of the period of the command
  std::int32_t provenance = 0;  // provenance of the input
  double input = 0.0;
};

inline double wall_clock() {  // s
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Opens a socket on the loopback interface with a free port.
class UdpSocket {
 public:
  UdpSocket() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in any = address(0);
    if (socket_ < 0 || bind(socket_, reinterpret_cast<sockaddr*>(&any), sizeof any) != 0) {
      std::perror("socket");
      std::exit(2);
    }
  }
  ~UdpSocket() { close(socket_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  int port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }
  // A failed transmission counts as a lost message.
  template <class Message>
  void send(const Message& message, int port) const {
    sockaddr_in there = address(port);
    sendto(socket_, &message, sizeof message, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&there),
           sizeof there);
  }
  int sender() const { return sender_; }  // port of the last message received
  // Waits at most until `until` on wall_clock(). Drops other messages.
  template <class Message>
  bool receive(Message& message, double until) {
    for (;;) {
      pollfd wanted{socket_, POLLIN, 0};
      const double left = until - wall_clock();
      const timespec rest{0, left > 0.0 ? static_cast<long>(1e9 * (left < 0.9 ? left : 0.9)) : 0};
      if (ppoll(&wanted, 1, &rest, nullptr) <= 0) {
        if (wall_clock() < until) continue;
        return false;
      }
      Message one;
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t bytes = recvfrom(socket_, &one, sizeof one, MSG_DONTWAIT | MSG_TRUNC,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (bytes == sizeof one && one.kind == Message{}.kind) {
        sender_ = ntohs(from.sin_port);
        message = one;
        return true;
      }
    }
  }

 private:
  static sockaddr_in address(int port) {
    sockaddr_in one{};
    one.sin_family = AF_INET;
    one.sin_port = htons(static_cast<std::uint16_t>(port));
    one.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return one;
  }
  int socket_, sender_ = 0;
};
