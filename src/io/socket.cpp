#include "io/socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace tellurion::io {
namespace {

constexpr int kMostWaiting = 16;  // to be let in
constexpr std::size_t kReceived_bytes = 64 * 1024;

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Result<Addresses> addressesOf(const NetAddress& address, bool toListen) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (toListen ? AI_PASSIVE : 0);
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.host.c_str(), fmt::format("{}", address.port).c_str(), &hints, &found);
  if (error != 0)
    return fail(Failure::Code::notFound, fmt::format("the host is not known: {}", ::gai_strerror(error)),
                formatNetAddress(address));
  return Addresses(found, ::freeaddrinfo);
}

bool setUp(int file) {
  const int yes = 1;
  return ::fcntl(file, F_SETFL, ::fcntl(file, F_GETFL) | O_NONBLOCK) == 0 && ::fcntl(file, F_SETFD, FD_CLOEXEC) == 0 &&
         ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes)) == 0;
}

bool isForNow(int error) {
  return error == EAGAIN || error == EINTR;
}

tl::unexpected<Failure> gone(std::string message) {
  return fail(Failure::Code::ioError, std::move(message));
}

sockaddr_storage ownAddressOf(int file) {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  if (::getsockname(file, reinterpret_cast<sockaddr*>(&address), &length) != 0) address.ss_family = AF_UNSPEC;
  return address;
}

}  // namespace

Socket::~Socket() {
  if (file_ >= 0) ::close(file_);
}
Socket::Socket(Socket&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
Socket& Socket::operator=(Socket&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

Result<Socket> Socket::listenOn(const NetAddress& address) {
  const auto addresses = addressesOf(address, true);
  if (!addresses) return tl::unexpected(addresses.error());
  int error = 0;
  for (const addrinfo* each = addresses->get(); each != nullptr; each = each->ai_next) {
    Socket socket(::socket(each->ai_family, each->ai_socktype, each->ai_protocol));
    const int yes = 1;
    // A leader that is started again finds its port free, though connections of the last one linger.
    const bool isListening = socket.isOpen() && setUp(socket.file_) &&
                             ::setsockopt(socket.file_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes)) == 0 &&
                             ::bind(socket.file_, each->ai_addr, each->ai_addrlen) == 0 &&
                             ::listen(socket.file_, kMostWaiting) == 0;
    if (isListening) return socket;
    error = errno;
  }
  return fail(Failure::Code::ioError,
              fmt::format("cannot be listened on: {}{}", std::strerror(error),
                          error == EADDRINUSE ? "; another program has this port, take another one" : ""),
              formatNetAddress(address));
}

Result<std::optional<Socket>> Socket::connectTo(const NetAddress& address, std::size_t which) {
  const auto addresses = addressesOf(address, false);
  if (!addresses) return tl::unexpected(addresses.error());
  const addrinfo* each = addresses->get();
  for (; each != nullptr && which > 0; --which)
    each = each->ai_next;
  if (each == nullptr) return std::optional<Socket>();
  Socket socket(::socket(each->ai_family, each->ai_socktype, each->ai_protocol));
  if (!socket.isOpen() || !setUp(socket.file_)) return gone(std::strerror(errno));
  if (::connect(socket.file_, each->ai_addr, each->ai_addrlen) != 0 && errno != EINPROGRESS && errno != EINTR)
    return gone(std::strerror(errno));
  return std::optional(std::move(socket));
}

std::string Socket::connectionProblem() const {
  int error = 0;
  socklen_t length = sizeof(error);
  if (::getsockopt(file_, SOL_SOCKET, SO_ERROR, &error, &length) != 0) error = errno;
  return error == 0 ? "" : std::strerror(error);
}

std::optional<Socket> Socket::accept() const {
  Socket socket(::accept(file_, nullptr, nullptr));
  if (!socket.isOpen() || !setUp(socket.file_)) return std::nullopt;
  return socket;
}

Result<std::size_t> Socket::send(std::string_view bytes) const {
  const ssize_t sent = ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (sent >= 0) return static_cast<std::size_t>(sent);
  if (isForNow(errno)) return std::size_t{0};
  return gone(std::strerror(errno));
}

Result<std::string> Socket::receive() const {
  std::string bytes(kReceived_bytes, '\0');
  const ssize_t got = ::recv(file_, bytes.data(), bytes.size(), 0);
  if (got == 0) return gone("the other side has ended");
  if (got < 0 && !isForNow(errno)) return gone(std::strerror(errno));
  bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return bytes;
}

std::uint16_t Socket::port() const {
  const sockaddr_storage own = ownAddressOf(file_);
  if (own.ss_family == AF_INET) return ntohs(reinterpret_cast<const sockaddr_in&>(own).sin_port);
  if (own.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6&>(own).sin6_port);
  return 0;
}

bool Socket::isLoopback() const {
  const sockaddr_storage own = ownAddressOf(file_);
  constexpr std::uint32_t kLoopback = 127;
  if (own.ss_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in&>(own).sin_addr.s_addr) >> 24 == kLoopback;
  if (own.ss_family != AF_INET6) return false;
  const in6_addr& address = reinterpret_cast<const sockaddr_in6&>(own).sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&address) || (IN6_IS_ADDR_V4MAPPED(&address) && address.s6_addr[12] == kLoopback);
}

std::string Socket::otherSide() const {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  if (::getpeername(file_, reinterpret_cast<sockaddr*>(&address), &length) != 0 ||
      ::getnameinfo(reinterpret_cast<const sockaddr*>(&address), length, host.data(), host.size(), port.data(),
                    port.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return "somebody";
  return std::strchr(host.data(), ':') ? fmt::format("[{}]:{}", host.data(), port.data())
                                       : fmt::format("{}:{}", host.data(), port.data());
}

Result<SocketWaker> SocketWaker::create() {
  std::array<int, 2> ends{-1, -1};
  if (::pipe(ends.data()) != 0) return gone(std::strerror(errno));
  SocketWaker waker;
  waker.reading_ = Socket(ends[0]);
  waker.writing_ = Socket(ends[1]);
  for (const int file : ends) {
    if (::fcntl(file, F_SETFL, O_NONBLOCK) != 0 || ::fcntl(file, F_SETFD, FD_CLOEXEC) != 0)
      return gone(std::strerror(errno));
  }
  return waker;
}

// A pipe that is full has been called often enough.
void SocketWaker::wake() const {
  [[maybe_unused]] const ssize_t ignored = ::write(writing_.file_, "!", 1);
}

void SocketWaker::calm() const {
  std::array<char, 256> calls{};
  while (::read(reading_.file_, calls.data(), calls.size()) > 0) {
  }
}

void waitForSockets(std::span<SocketWait> waits, const SocketWaker& waker, std::chrono::milliseconds atMost) {
  std::vector<pollfd> polled{{.fd = SocketWait::fileOf(waker), .events = POLLIN, .revents = 0}};
  for (const SocketWait& wait : waits)
    polled.push_back({.fd = SocketWait::fileOf(*wait.socket),
                      .events = static_cast<short>(POLLIN | (wait.toWrite ? POLLOUT : 0)),
                      .revents = 0});
  ::poll(polled.data(), polled.size(), static_cast<int>(std::max<std::int64_t>(atMost.count(), 0)));
  waker.calm();
  for (std::size_t i = 0; i < waits.size(); ++i) {
    const int events = polled[i + 1].revents;
    waits[i].canRead = (events & (POLLIN | POLLERR | POLLHUP | POLLNVAL)) != 0;
    waits[i].canWrite = (events & POLLOUT) != 0;
  }
}

}  // namespace tellurion::io
