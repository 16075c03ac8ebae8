#include "pci_devices.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "fd.h"
#include "gicube/wire/pci_config.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;

// A file of one number, as "0x4749"; 0 if there is none.
unsigned long number_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string text;
  stream >> text;
  return std::strtoul(text.c_str(), nullptr, 0);
}

bool is_board(const fs::path& folder) {
  return number_in(folder / "vendor") == wire::kVendorId && number_in(folder / "device") == wire::kDeviceId;
}

// A process that has opened a function holds a lock on its registers. Who may not look at them sees whether it masters
// the bus.
bool is_in_use(const fs::path& folder) {
  const Fd registers(::open((folder / "resource0").c_str(), O_RDWR | O_CLOEXEC));
  if (registers.get() >= 0) return ::flock(registers.get(), LOCK_EX | LOCK_NB) != 0;
  std::ifstream config(folder / "config", std::ios::binary);
  config.seekg(wire::pci::kCommandStatus);
  return (static_cast<unsigned>(config.get()) & wire::pci::kCommandBusMaster) != 0 && config.good();
}

}  // namespace

fs::path pci_folder(const std::string& address, const fs::path& sys) { return sys / "bus/pci/devices" / address; }

std::string kernel_driver_of(const fs::path& folder) {
  std::error_code error;
  return fs::read_symlink(folder / "driver", error).filename().string();
}

std::vector<PciDevice> pci_devices(const fs::path& sys) {
  std::vector<PciDevice> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(pci_folder("", sys), error)) {
    if (is_board(entry.path())) found.push_back({entry.path().filename().string(), is_in_use(entry.path())});
  }
  std::ranges::sort(found, {}, &PciDevice::address);
  return found;
}

std::vector<PciCondition> pci_conditions(const std::string& address, const fs::path& sys) {
  std::vector<PciCondition> conditions;
  const auto holds = [&](bool does, const std::string& question, const std::string& answer, const std::string& advice) {
    conditions.push_back({does, question, answer, does ? "" : advice});
    return does;
  };
  const fs::path folder = pci_folder(address, sys);
  std::error_code error;
  if (!holds(fs::exists(folder, error), "is there a PCI function?", address, "lspci lists those that there are"))
    return conditions;
  if (!holds(is_board(folder), "is it a GI-Cube board?",
             fmt::format("{:04x}:{:04x}", number_in(folder / "vendor"), number_in(folder / "device")),
             fmt::format("a board is {:04x}:{:04x}; lspci -d {:04x}: lists them", wire::kVendorId, wire::kDeviceId,
                         wire::kVendorId)))
    return conditions;
  const std::string driver = kernel_driver_of(folder);
  if (!holds(driver.empty() || driver == kUioDriver, "is it free of other kernel drivers?",
             driver.empty() ? "it is bound to none" : "it is bound to " + driver,
             fmt::format("echo {} > {}/driver/unbind", address, folder.string())))
    return conditions;
  const fs::path registers = folder / "resource0";
  const int denied = ::access(registers.c_str(), R_OK | W_OK) != 0 ? errno : 0;
  if (!holds(denied == 0, "may its registers be mapped?",
             denied == 0 ? registers.string() : fmt::format("{}: {}", registers.string(), std::strerror(denied)),
             "run as root: an application that drives a PCI function has the rights of a kernel driver"))
    return conditions;
  const fs::path pages = sys / "kernel/mm/hugepages/hugepages-2048kB/free_hugepages";
  holds(number_in(pages) > 0, "is there a huge page for its rings?",
        fmt::format("{} free pages of 2 MiB", number_in(pages)), "echo 4 > /proc/sys/vm/nr_hugepages");
  return conditions;
}

}  // namespace gicube
