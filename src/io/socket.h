#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/failure.h"
#include "io/net_address.h"

namespace tellurion::io {

/// A TCP socket that never waits by itself: waitForSockets() does. What is sent goes out at once (TCP_NODELAY).
/// Move-only; one thread at a time.
class Socket {
 public:
  Socket() = default;
  ~Socket();
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;

  /// Asks the DNS for names, which may take seconds. Fails where the port is taken, or the address is none of this
  /// machine's.
  static Result<Socket> listenOn(const NetAddress& address);
  /// Begins to connect to the host's `which`-th address; nothing: it has no more. Done, or failed, once it can be
  /// written to: connectionProblem() says which. Asks the DNS for names.
  static Result<std::optional<Socket>> connectTo(const NetAddress& address, std::size_t which);
  /// Empty: it is connected.
  std::string connectionProblem() const;

  /// Somebody who waits to be let in; nothing: nobody.
  std::optional<Socket> accept() const;

  /// How many of the bytes it took; 0: none for now. Fails where the connection is gone.
  Result<std::size_t> send(std::string_view bytes) const;
  /// What has come, at most 64 KiB; empty: nothing for now. Fails where the other side is gone or has closed.
  Result<std::string> receive() const;

  std::uint16_t port() const;     ///< its own
  bool isLoopback() const;        ///< what it listens on, no other machine can reach
  std::string otherSide() const;  ///< "192.0.2.1:4711"
  bool isOpen() const { return file_ >= 0; }

 private:
  friend class SocketWaker;
  friend struct SocketWait;
  explicit Socket(int file) : file_(file) {}
  int file_ = -1;
};

/// Ends a waitForSockets() from another thread. Thread-safe.
class SocketWaker {
 public:
  static Result<SocketWaker> create();
  void wake() const;
  void calm() const;  ///< forgets the calls so far

 private:
  friend struct SocketWait;
  Socket reading_;
  Socket writing_;
};

/// One to wait for, and what has become of it.
struct SocketWait {
  const Socket* socket = nullptr;  ///< not null
  bool toWrite = false;            ///< wait until it can be written to as well
  bool canRead = false;            ///< or has failed
  bool canWrite = false;

  static int fileOf(const Socket& socket) { return socket.file_; }
  static int fileOf(const SocketWaker& waker) { return waker.reading_.file_; }
};

/// Until one can be read, or written to where that is asked for, or the waker was called, or the time is over.
void waitForSockets(std::span<SocketWait> waits, const SocketWaker& waker, std::chrono::milliseconds atMost);

}  // namespace tellurion::io
