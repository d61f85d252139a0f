"""Constants and GUIDs: values copied from reference/vci.md sections 2, 3 and 6."""

from __future__ import annotations

from uuid import UUID

import pytest

from canwire.vci import controller_types
from canwire.vci.can import presets as bit_timing_presets
from canwire.vci.can.structures import CanBtp
from canwire.vci.structures import constants, guids
from tests.cases import each

# reference/vci.md section 3, group by group
CAN = {
    "CAN_OPMODE_": "UNDEFINED 0, STANDARD 0x01, EXTENDED 0x02, ERRFRAME 0x04, LISTONLY 0x08, LOWSPEED 0x10,"
    " AUTOBAUD 0x20",
    "CAN_EXMODE_": "DISABLED 0, EXTDATA 0x01, FASTDATA 0x02, NONISO 0x04",
    "CAN_BTMODE_": "RAW 0x01, TSM 0x02",
    "CAN_BUSC_": "UNDEFINED 0, LOWSPEED 1, HIGHSPEED 2",
    "CAN_STATUS_": "TXPEND 0x01, OVRRUN 0x02, ERRLIM 0x04, BUSOFF 0x08, ININIT 0x10, BUSCERR 0x20",
    "CAN_FEATURE_": "STDOREXT 0x1, STDANDEXT 0x2, RMTFRAME 0x4, ERRFRAME 0x8, BUSLOAD 0x10, IDFILTER 0x20,"
    " LISTONLY 0x40, SCHEDULER 0x80, GENERRFRM 0x100, DELAYEDTX 0x200, SINGLESHOT 0x400, HIGHPRIOR 0x800,"
    " AUTOBAUD 0x1000, EXTDATA 0x2000, FASTDATA 0x4000, ISOFRAME 0x8000, NONISOFRM 0x10000,"
    " 64BITTSC 0x20000, STDREXT 0x1, STDANEXT 0x2, SINGLESOT 0x400",
    "CAN_FILTER_": "STD 1, EXT 2, VOID 0, LOCK 1, PASS 2, INCL 3, EXCL 4, SRRA 0x80, SRR 0x80,"
    " SIZE_STD 2048, SIZE_EXT 2048",
    "CAN_ACC_": "MASK_ALL 0, CODE_ALL 0, MASK_NONE 0xFFFFFFFF, CODE_NONE 0x80000000",
    "CAN_MSGTYPE_": "DATA 0, INFO 1, ERROR 2, STATUS 3, WAKEUP 4, TIMEOVR 5, TIMERST 6",
    "CAN_MSGID_": "MASK11 0x7FF, MASK29 0x1FFFFFFF, INVALID 0xE0000000, INFO 0xFFFFFFFF, ERROR 0xFFFFFFFF,"
    " STATUS 0xFFFFFFFF, WAKEUP 0xFFFFFFFF",
    "CAN_INFO_": "START 1, STOP 2, RESET 3",
    "CAN_ERROR_": "NONE 0, STUFF 1, FORM 2, ACK 3, BIT 4, FDB 5, CRC 6, DLC 7, OTHER 8",
    "CAN_ACCEPT_": "REJECT 0, FILTER_1 1, FILTER_2 2, PASSEXCL 3, ALWAYS 0xFF, FILTER1 1, FILTER2 2, EXCL 3",
    "CAN_CTXMSG_": "INC_NO 0, INC_ID 1, INC_8 2, INC_16 3, STAT_EMPTY 0, STAT_BUSY 1, STAT_DONE 2",
    "CAN_CTXTSK_STAT_": "STOPPED 0, RUNNING 1",
    "CAN_MAX_": "CTX_MSGS 16",
    "CAN_RTI_LOCKSTAT_": "CTL 1, SHD 2, CHN 0x80000000",
    "CAN_SDLC_": "MAX 8",
    "CAN_SLEN_": "MAX 8",
    "CAN_EDLC_": "MAX 15",
    "CAN_ELEN_": "MAX 64",
    "CAN_BTR_": "TABEL_SIZE 64, TABLE_SIZE 64",
    "CAN_BTP_": "TABEL_SIZE 64, TABLE_SIZE 64",
    "CAN_MSGFLAGS_": "DLC 0x0F, OVR 0x10, SRR 0x20, RTR 0x40, EXT 0x80",
    "CAN_MSGFLAGS2_": "SSM 0x01, HPM 0x02, EDL 0x04, FDR 0x08, ESI 0x10, RES 0xE0",
    "DCAN_STATUS_": "BUSCERR 0x20",
}

CONTROLLERS = (
    "UNKNOWN 0, 82527 1, 82C200 2, 81C90 3, 81C92 4, SJA1000 5, 82C900 6, TOUCAN 7, MSCAN 8, FLEXCAN 9,"
    " IFICAN 0x0A, BCCAN 0x0B, BXCAN 0x0C, IFICFD 0x0D, BMCAN 0x0E, IFICFD2 0x41, BMCAN2 0x42"
)

# bit/s -> BT0, BT1 at 16 MHz: VCI V4 manual 5.2.3; 667 from python-can
BIT_TIMINGS = {
    5: (0x3F, 0x7F),
    10: (0x31, 0x1C),
    20: (0x18, 0x1C),
    50: (0x09, 0x1C),
    100: (0x04, 0x1C),
    125: (0x03, 0x1C),
    250: (0x01, 0x1C),
    500: (0x00, 0x1C),
    667: (0x00, 0x18),
    800: (0x00, 0x16),
    1000: (0x00, 0x14),
}

# reference/vci.md section 3: name -> bit/s, TS1, TS2, SJW, TDO
PRESETS = {
    "EMPTY": (0, 0, 0, 0, 0),
    "5KB": (5000, 17, 8, 1, 0),
    **{f"{rate}KB": (rate * 1000, 14, 2, 1, 0) for rate in (10, 20, 50, 100, 125, 250, 500)},
    "800KB": (800_000, 8, 2, 1, 0),
    "1000KB": (1_000_000, 6, 2, 1, 0),
    "ABR_SL_500KB": (500_000, 6400, 1600, 1600, 0),
    "DBR_SL_1000KB": (1_000_000, 1600, 400, 400, 1600),
    "DBR_SL_2000KB": (2_000_000, 1600, 400, 400, 1600),
    "DBR_SL_4000KB": (4_000_000, 800, 200, 200, 800),
    "DBR_SL_5000KB": (5_000_000, 600, 200, 200, 600),
    "DBR_SL_6667KB": (6_666_666, 400, 200, 200, 402),
    "DBR_SL_8000KB": (8_000_000, 400, 100, 100, 250),
    "DBR_SL_10000KB": (10_000_000, 300, 100, 100, 200),
    "ABR_LL_250KB": (250_000, 6400, 1600, 1600, 0),
    "DBR_LL_500KB": (500_000, 6400, 1600, 1600, 6400),
    "DBR_LL_833KB": (833_333, 1600, 400, 400, 1620),
    "DBR_LL_1000KB": (1_000_000, 1600, 400, 400, 1600),
    "DBR_LL_1538KB": (1_538_461, 1000, 300, 300, 1040),
    "DBR_LL_2000KB": (2_000_000, 800, 200, 200, 770),
    "DBR_LL_4000KB": (4_000_000, 800, 200, 200, 800),
}


def values(row: str) -> dict[str, int]:
    """ "NAME 0x1, OTHER 2" as a dictionary."""
    return {name: int(value, 0) for name, value in (entry.split() for entry in row.split(","))}


def numbers(module: object) -> set[str]:
    return {name for name, value in vars(module).items() if name.isupper() and isinstance(value, int)}


@each("group", CAN)
def test_can_constants(group: str) -> None:
    for name, value in values(CAN[group]).items():
        assert getattr(constants, group + name) == value, group + name


def test_the_table_above_is_complete() -> None:
    listed = {group + name for group, row in CAN.items() for name in values(row)}
    timings = {f"CAN_BT{which}_{rate}KB" for which in "01" for rate in BIT_TIMINGS}
    assert numbers(constants) == listed | timings


@pytest.mark.conforms("X4-21")
@each("rate", BIT_TIMINGS)
def test_bit_timing_registers(rate: int) -> None:
    pair = getattr(constants, f"CAN_BT0_{rate}KB"), getattr(constants, f"CAN_BT1_{rate}KB")
    assert pair == BIT_TIMINGS[rate]


@pytest.mark.conforms("X4-21")
@each("rate", BIT_TIMINGS)
def test_registers_make_their_bit_rate(rate: int) -> None:
    """Bit rate = 16 MHz / (2 * BRP * (1 + TS1 + TS2)): reference/vci.md section 3."""
    bt0, bt1 = BIT_TIMINGS[rate]
    made = 16e6 / (2 * ((bt0 & 63) + 1) * (3 + (bt1 & 15) + (bt1 >> 4 & 7)))
    assert made == pytest.approx(rate * 1000, rel=1e-3)


@each(("name", "value"), values(CONTROLLERS).items())
def test_controller_types(name: str, value: int) -> None:
    assert getattr(controller_types, f"CAN_CTRL_{name}") == value
    assert getattr(controller_types, f"CAN_TYPE_{name}") == value
    assert getattr(controller_types, f"VCI_CAN_{name}") == 0x100 + value


def test_buses_and_ranges() -> None:
    expected = {
        "VCI_BUS_": "RES 0, CAN 1, LIN 2, KLN 3, FXR 4",
        "CAN_CTRL_": "CANMIN 0, CANMAX 0x3F, CFDMIN 0x40, GENCFD 0x40, CFDMAX 0x7F, MAXVAL 0xFF",
        "VCI_MAX_": "BUSCTRL 32",
        "BAL_MAX_": "SOCKETS 32",
    }
    for group, row in expected.items():
        for name, value in values(row).items():
            assert getattr(controller_types, group + name) == value, group + name


def test_bus_and_controller_words() -> None:
    word = controller_types.vci_bus_ctrl(controller_types.VCI_BUS_CAN, controller_types.CAN_CTRL_BMCAN2)
    assert word == 0x0142
    assert controller_types.vci_bus_type(word) == controller_types.VCI_BUS_CAN
    assert controller_types.vci_ctl_type(word) == controller_types.CAN_CTRL_BMCAN2


def test_message_flag_makers() -> None:
    assert constants.can_make_msgflags(dlc=8, ovr=1, srr=0, rtr=1, ext=1) == 0xD8
    assert constants.can_make_msgflags(dlc=0x1F, ovr=2, srr=1, rtr=2, ext=0) == 0x2F
    assert constants.can_make_msgflags2(ssm=1, hpm=0, edl=1, fdr=1, esi=0) == 0x0D
    assert constants.can_make_msgflags2(ssm=0, hpm=1, edl=0, fdr=0, esi=3) == 0x12


@each(
    ("dlc", "length"),
    [*((n, n) for n in range(9)), (9, 12), (10, 16), (11, 20), (12, 24), (13, 32), (14, 48), (15, 64)],
)
def test_data_length_codes(dlc: int, length: int) -> None:
    """VCI V4 manual 7.3.14."""
    assert constants.can_edlc_to_len(dlc) == length
    assert constants.can_len_to_edlc(length) == dlc
    assert constants.can_sdlc_to_len(dlc) == constants.can_len_to_sdlc(length) == min(dlc, 8)


def test_lengths_between_the_codes_and_beyond() -> None:
    assert [constants.can_len_to_edlc(n) for n in (9, 12, 13, 33, 49, 65, -1)] == [9, 9, 10, 14, 15, 15, 15]
    assert [constants.can_edlc_to_len(n) for n in (16, -1)] == [64, 64]
    assert [constants.can_sdlc_to_len(n) for n in (9, -1)] == [8, 8]
    assert [constants.can_len_to_sdlc(n) for n in (9, -1)] == [8, 8]


@each("name", PRESETS)
def test_bit_timing_presets(name: str) -> None:
    preset = getattr(bit_timing_presets, f"CAN_BTP_{name}")
    assert preset == CanBtp(0, *PRESETS[name])
    assert preset.to_bytes() == CanBtp(0, *PRESETS[name]).to_bytes()


def test_no_preset_is_missing() -> None:
    found = {name for name in vars(bit_timing_presets) if name.startswith("CAN_BTP_")}
    assert found == {f"CAN_BTP_{name}" for name in PRESETS}


def test_presets_cannot_be_changed_but_their_copies() -> None:
    with pytest.raises(AttributeError, match=r"copy\(\)"):
        bit_timing_presets.CAN_BTP_500KB.sjw = 2
    own = bit_timing_presets.CAN_BTP_500KB.copy()
    own.sjw = 2
    assert own != bit_timing_presets.CAN_BTP_500KB
    assert bit_timing_presets.CAN_BTP_500KB.sjw == 1
    assert repr(bit_timing_presets.CAN_BTP_500KB) == "CanBtp(bps=500000, ts1=14, ts2=2, sjw=1)"


# reference/vci.md section 6
INTERFACES = """
IUnknown 00000000-0000-0000-C000-000000000046
IVciFifo 25A79E68-912C-41BF-8CC7-A709672FF102
IVciFifo2 66E3AA3A-6BF6-47A0-AB18-EFC801091E61
IFifoReader 19286603-A9CD-433A-A495-72E5C9D97A97
IFifoWriter E1CC08CE-99C0-483B-8E5F-4C43358E1CE2
IVciDevice 46DFCF2F-113B-4D01-A803-BD5B4D32C8F1
IVciDevice2 CDC08670-C314-4CA1-BA6A-51016BB7C23A
IDevStatus B2485033-9FF6-407C-9C2F-2692FB68319C
IVciEnumDevice 1AD18613-CC67-4AC8-83FA-6AD24BDE629A
IVciDeviceManager 7724B0A9-E6DB-46B0-A5D0-468CC4191732
IBalObject A2B958AA-9188-4CDB-8307-25D9F1F843E9
ICanControl D213C143-7039-4D1D-ACED-1390289C8EBA
ICanControl2 EFD3A8E2-09E3-4115-869F-93E579167431
ICanScheduler C936498F-EC52-4C74-B3FE-A472BA7365BA
ICanScheduler2 70E3E8B8-852F-48E0-BDDB-B10A0C44CB3F
ICanSocket 48965C25-9F8D-4E4D-8DE6-F029808C9ED2
ICanSocket2 D914F5A7-12FA-41F6-8AB4-4EA89F1C5F1E
ICanStatus 10795437-1028-4A32-910D-0E19236224DA
ICanStatus2 F686F1A4-4AC5-438B-A676-18CF6B9BA422
ICanObject B346CF15-5CD5-4E08-9EF1-3AEA3F34AE0C
ICanObject2 264853AB-7D0C-4690-924D-97F06B5BD31C
ICanChannel 66FF396B-22EA-42AA-BC7E-4919F89FB45C
ICanChannel2 F2528F90-3A10-46D0-8F82-0871C1E7DBB9
ILinMonitor 29068E57-6B69-4010-911C-7A9128521BE0
ILinControl 4D58EF55-4F01-451E-911F-17C223A8B8F0
ILinSocket EF865638-6D07-4A46-A838-4BAFED359B1A
"""
DEVICES = """
PC-I04/PCI | E7752D2E-28A3-4318-AF0C-02C756FBC25A | CAN-IB500/PCIe | 84A67EBC-2C6D-4B9B-A75F-768F638A4669
iPC-I165/PCI | 1E28CE42-10AB-41A8-BF00-4DA611AB05FF | CAN-IB600/PCIe | 07797568-2F25-491A-862D-9254BFEBF2CD
iPC-I320/PCI | 78B139E9-503A-47A8-B671-B2FC29444717 | CAN-IB640/PCIe | B230EAD1-4EC7-412B-B064-56C53A357C93
iPC-I XC16/PCI | 789CE2B8-814B-48A9-816A-C2E7C1E7D731 | CAN-IB700/PCI | 89545925-7FE7-4353-98F6-65156A47B27A
iPC-I XC16/PCIe | A196624D-DCC4-41B1-819B-16FFA1125589 | CAN-IB800/PCI | CCD3C223-435F-4975-8317-0D29B0102B83
USB-to-CAN compact | 853857B3-0B08-454C-93FB-2D166B72A5AA | CANblue | 021AAC76-B2FA-4909-BEB1-67D6C2283359
USB-to-CAN II | 13942C1E-CD73-4B7A-978B-8C2CD0B48394 | CANblue II | 321C186D-F9D6-499C-89E0-A9DA5261BA0B
USB-to-CAN V2 | 2219F6A0-732A-4750-B66F-0AE731FB40E1 | CAN@net II | 97C04C74-FA6D-439D-9E32-359486385607
USB-to-CAN FD | B9AAAF39-B9B9-4850-9402-7D8250C7B88F | CAN@net NT USB | 0F254982-BCEE-40AC-8EB8-906F773D00FA
CAN-IB100/PCIe | 1448FCFF-73DC-478A-B60D-058E374417C8 | CAN@net NT Ethernet | F70A8D3A-CBE0-42B6-8F04-E3E3B46DD3B3
CAN-IB200/PCIe | 3624894F-2F83-49D4-A874-8DB120AB5913 | CANbridge | EDCCFFED-C78C-4242-B617-56320E33A361
CAN-IB300/PCI | 2F7B75C6-A3F0-4F0B-94C7-010B663B7E5A | INpact | BB27BD36-7A40-4712-BBAA-13B3421731C8
CAN-IB400/PCI | 6082B7B5-B305-45FC-A3A2-7F97C9F92865 | demo driver | 661DC760-AFA5-4D55-86F5-FABC63600A54
"""


def test_interface_identifiers() -> None:
    expected = {
        name: UUID(value) for name, value in (line.split() for line in INTERFACES.split("\n") if line)
    }
    assert expected == guids.INTERFACES
    assert all(getattr(guids, f"IID_{name}") == value for name, value in expected.items())
    assert UUID("3CB880F4-2791-40BD-B852-09349D1A7B37") == guids.CLSID_VCIBAL


def test_device_classes() -> None:
    cells = [cell.strip() for line in DEVICES.strip().splitlines() for cell in line.split("|")]
    assert dict(zip(cells[::2], map(UUID, cells[1::2]), strict=True)) == guids.DEVICE_CLASSES
    named = {value for name, value in vars(guids).items() if name.startswith("GUID_")}
    assert named == set(guids.DEVICE_CLASSES.values())
    assert guids.DEVICE_CLASSES["USB-to-CAN FD"] == guids.GUID_USB2CAN_FD_DEVICE
