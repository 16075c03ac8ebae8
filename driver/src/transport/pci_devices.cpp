#include "pci_devices.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "gicube/wire/pci_config.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;

// The number in a file, such as "0x4749"; 0 if there is none.
unsigned long number_in(const fs::path& file) {
  std::string text;
  std::ifstream(file) >> text;
  return std::strtoul(text.c_str(), nullptr, 0);
}

std::string ids(unsigned long vendor, unsigned long device) { return fmt::format("{:04x}:{:04x}", vendor, device); }
std::string ids_in(const fs::path& folder) { return ids(number_in(folder / "vendor"), number_in(folder / "device")); }
std::string ids_of_board() { return ids(wire::kVendorId, wire::kDeviceId); }

// A function that is open is a bus master.
bool is_in_use(const fs::path& folder) {
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
    if (ids_in(entry.path()) == ids_of_board())
      found.push_back({entry.path().filename().string(), is_in_use(entry.path())});
  }
  std::ranges::sort(found, {}, &PciDevice::address);
  return found;
}

std::vector<PciCondition> pci_conditions(const std::string& address, const fs::path& sys) {
  const fs::path folder = pci_folder(address, sys), registers = folder / "resource0";
  std::error_code error;
  const std::string seen = ids_in(folder), driver = kernel_driver_of(folder);
  const int denied = ::access(registers.c_str(), R_OK | W_OK) != 0 ? errno : 0;
  const unsigned long pages = number_in(sys / "kernel/mm/hugepages/hugepages-2048kB/free_hugepages");
  std::vector<PciCondition> conditions{
      {fs::exists(folder, error), "is there a PCI function?", address, "lspci lists the functions of this machine"},
      {seen == ids_of_board(), "is it a GI-Cube board?", seen,
       fmt::format("a board is {}; lspci -d {:04x}: lists them", ids_of_board(), wire::kVendorId)},
      {driver.empty() || driver == "uio_pci_generic", "is it free of other kernel drivers?",
       "it is bound to " + (driver.empty() ? "none" : driver),
       fmt::format("echo {} > {}/driver/unbind", address, folder.string())},
      {denied == 0, "may its registers be mapped?",
       registers.string() + (denied == 0 ? "" : std::string(": ") + std::strerror(denied)),
       "run as root: an application that drives a PCI function has the rights of a kernel driver"},
      {pages > 0, "is there a huge page for its rings?", fmt::format("{} free pages of 2 MiB", pages),
       "echo 4 > /proc/sys/vm/nr_hugepages"}};
  const auto fault = std::ranges::find(conditions, false, &PciCondition::holds);
  if (fault != conditions.end()) conditions.erase(fault + 1, conditions.end());
  return conditions;
}

}  // namespace gicube
