#pragma once

#include <curl/curl.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "io/resources.h"

namespace tellurion::io {

/// A folder of its own, gone at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "tellurion_io_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "no scratch folder";
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
  }

 private:
  std::filesystem::path path_;
};

/// tests/fault_server.py on a folder, as long as this lives.
class FaultServer {
 public:
  explicit FaultServer(const std::filesystem::path& folder) {
    std::array<int, 2> in{};
    std::array<int, 2> out{};
    if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) return;
    const std::string script = TELLURION_SOURCE_DIR "/tests/fault_server.py";
    child_ = fork();
    if (child_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      execlp("python3", "python3", script.c_str(), "--folder", folder.c_str(), nullptr);
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    input_ = in[1];
    std::FILE* const text = fdopen(out[0], "r");
    EXPECT_EQ(std::fscanf(text, "%d %d", &port_, &controlPort_), 2) << "tests/fault_server.py does not start";
    std::fclose(text);
  }
  ~FaultServer() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    close(input_);
  }
  FaultServer(const FaultServer&) = delete;
  FaultServer& operator=(const FaultServer&) = delete;

  std::string url(const std::string& path) const { return "http://127.0.0.1:" + std::to_string(port_) + path; }

  /// "set?prefix=/&fault=hang", "clear", ... as the script's head says.
  nlohmann::json tell(const std::string& command) const {
    std::string answer;
    CURL* const easy = curl_easy_init();
    const std::string target = "http://127.0.0.1:" + std::to_string(controlPort_) + "/" + command;
    curl_easy_setopt(easy, CURLOPT_URL, target.c_str());
    curl_easy_setopt(easy, CURLOPT_PROXY, "");
    curl_easy_setopt(easy, CURLOPT_FAILONERROR, 1L);
    curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &FaultServer::append);
    curl_easy_setopt(easy, CURLOPT_WRITEDATA, &answer);
    EXPECT_EQ(curl_easy_perform(easy), CURLE_OK) << command;
    curl_easy_cleanup(easy);
    return nlohmann::json::parse(answer, nullptr, false);
  }
  nlohmann::json state() const { return tell("state"); }
  int count(const std::string& path) const { return state()["counts"].value(path, 0); }
  int countOfAll() const { return static_cast<int>(state()["order"].size()); }

 private:
  static std::size_t append(const char* data, std::size_t size, std::size_t count, void* answer) {
    static_cast<std::string*>(answer)->append(data, size * count);
    return size * count;
  }

  pid_t child_ = -1;
  int input_ = -1;
  int port_ = 0;
  int controlPort_ = 0;
};

inline constexpr double kPatience_s = 240.0;

/// Whether it comes true within the patience of a test.
inline bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kPatience_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// So many bytes that no compression and no accident gives.
inline std::string noise(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::string text(size, '\0');
  for (char& c : text)
    c = static_cast<char>(random() & 0xff);
  return text;
}

inline std::string textOf(const Resource& resource) {
  return {reinterpret_cast<const char*>(resource.bytes.data()), resource.bytes.size()};
}

/// Times for tests: what takes seconds in earnest takes hundredths.
inline ResourceOptions quickOptions() {
  return {.connectTimeout_s = 5.0, .stallTimeout_s = 1.0, .firstRetry_s = 0.03, .longestRetry_s = 0.2};
}

/// What came for a request, and how often.
struct Arrival {
  std::mutex mutex;
  int calls = 0;
  std::optional<Result<std::shared_ptr<const Resource>>> result;

  Resources::Ready ready() {
    return [this](const Result<std::shared_ptr<const Resource>>& answer) {
      const std::scoped_lock lock(mutex);
      ++calls;
      result = answer;
    };
  }
  int count() {
    const std::scoped_lock lock(mutex);
    return calls;
  }
};

}  // namespace tellurion::io
