"""Joules that the RDRAM channels of a board take, from the commands of a trace alone and the prices of a data sheet.

    python3 memory_energy.py COMMANDS NAME=NUMBER...

COMMANDS has a line for each command, "channel device name". The names are those of EnergyConfig without rdram_, and
seconds, clock_khz,
channels and devices (of all channels). Prints the energy of the devices and of the interface cells."""
import collections
import sys

PRICES = {"ACT": "activate_fj", "RD": "read_fj", "WR": "write_fj", "REFA": "refresh_fj"}
CLOCKS = 4  # of the data of a packet, in which one device is in attention


def main():
    of = {name: float(number) for name, number in (word.split("=") for word in sys.argv[2:])}
    with open(sys.argv[1], encoding="ascii") as lines:
        count = collections.Counter(line.split()[2] for line in lines)
    packets = count["RD"] + count["WR"]
    attention = packets * CLOCKS / (of["clock_khz"] * 1e3)
    events = sum(count[name] * of[price] for name, price in PRICES.items())
    resting = (of["devices"] * of["seconds"] - attention) * of["standby_uw"]
    print(repr(1e-6 * (resting + attention * of["attention_uw"]) + 1e-15 * events),
          repr(1e-15 * packets * of["io_fj"] + 1e-6 * of["interface_uw"] * of["channels"] * of["seconds"]))


if __name__ == "__main__":
    main()
