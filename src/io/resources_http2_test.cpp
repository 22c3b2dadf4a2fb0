#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdlib>
#include <set>
#include <sstream>

#include "io/fault_server_test.h"
#include "io/resources.h"

namespace tellurion::io {
namespace {

int freePort() {
  const int probe = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(bind(probe, generic, size), 0);
  EXPECT_EQ(getsockname(probe, generic, &size), 0);
  close(probe);
  return ntohs(address.sin_port);
}

// nginx with TLS and HTTP/2 on a folder, trusted by nobody who is not told to.
class Http2Test : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v nginx openssl > /dev/null") != 0) GTEST_SKIP() << "needs nginx and openssl";
    const std::string here = folder.path().string();
    const std::string makeKey =
        "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=127.0.0.1"
        " -addext subjectAltName=IP:127.0.0.1 -keyout " +
        here + "/key.pem -out " + here + "/cert.pem 2> /dev/null";
    ASSERT_EQ(std::system(makeKey.c_str()), 0);
    port = freePort();
    std::ostringstream config;
    config << "daemon off; master_process off; pid " << here << "/pid; error_log " << here << "/error.log; events {}\n"
           << "http { log_format brief '$server_protocol $connection'; access_log " << here << "/access.log brief;\n"
           << "client_body_temp_path " << here << "/t1; proxy_temp_path " << here << "/t2; fastcgi_temp_path " << here
           << "/t3;"
           << " uwsgi_temp_path " << here << "/t4; scgi_temp_path " << here << "/t5;\n"
           << "server { listen 127.0.0.1:" << port
           << " ssl http2; ssl_certificate cert.pem; ssl_certificate_key key.pem; root " << here << "/www; } }\n";
    folder.write("nginx.conf", config.str());
    nginx = fork();
    if (nginx == 0) {
      const int quiet = ::open("/dev/null", O_WRONLY);
      dup2(quiet, STDERR_FILENO);
      execlp("nginx", "nginx", "-p", here.c_str(), "-c", "nginx.conf", nullptr);
      _exit(127);
    }
    ASSERT_TRUE(eventually([&] { return std::filesystem::exists(folder / "pid"); }));
  }
  void TearDown() override {
    if (nginx <= 0) return;
    kill(nginx, SIGKILL);
    waitpid(nginx, nullptr, 0);
  }

  ScratchFolder folder;
  pid_t nginx = -1;
  int port = 0;
};

TEST_F(Http2Test, ManyRequestsShareOneConnection) {
  constexpr int kFiles = 100;
  for (int i = 0; i < kFiles; ++i)
    folder.write("www/" + std::to_string(i), noise(2000, static_cast<unsigned>(i)));
  ResourceOptions options = quickOptions();
  options.authorities = folder / "cert.pem";
  Arrival arrival;
  {
    Resources resources(options);
    std::vector<Resources::Ticket> tickets;
    for (int i = 0; i < kFiles; ++i) {
      const std::string url = "https://127.0.0.1:" + std::to_string(port) + "/" + std::to_string(i);
      tickets.push_back(resources.get({.url = url}, 1.0, arrival.ready()));
    }
    ASSERT_TRUE(eventually([&] { return arrival.count() == kFiles; }));
    EXPECT_EQ(resources.statistics().failedRequests, 0U);
  }
  std::ifstream log(folder / "access.log");
  std::set<std::string> connections;
  int lines = 0;
  std::string protocol;
  std::string connection;
  for (; log >> protocol >> connection; ++lines) {
    EXPECT_EQ(protocol, "HTTP/2.0");
    connections.insert(connection);
  }
  EXPECT_EQ(lines, kFiles);
  EXPECT_EQ(connections.size(), 1U);
}

TEST_F(Http2Test, AServerThatNobodyVouchesForIsNotTrusted) {
  folder.write("www/a", "a");
  Resources resources(quickOptions());
  const auto answer = resources.wait({.url = "https://127.0.0.1:" + std::to_string(port) + "/a"}, 0.5);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("no secure connection"), std::string::npos) << answer.error().message;
}

}  // namespace
}  // namespace tellurion::io
