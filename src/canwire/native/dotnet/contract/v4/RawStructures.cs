// VCI's structures under the names that the contract gives them; no interface hands them out.
// Source: the vendor's published contract of Ixxat.Vci4.
using System.Runtime.InteropServices;

#pragma warning disable 1591
namespace Ixxat.Vci4.Bal.Can
{
    [StructLayout(LayoutKind.Sequential)]
    public struct mgdCANMSGINFO
    {
        public byte bType, bReserved, bFlags, bAccept;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct mgdCANMSG
    {
        public uint dwTime, dwMsgId;
        public mgdCANMSGINFO uMsgInfo;
        public byte bData1, bData2, bData3, bData4, bData5, bData6, bData7, bData8;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct mgdCANMSG2
    {
        public uint dwTime, _rsvd_, dwMsgId;
        public mgdCANMSGINFO uMsgInfo;
        public byte bData1, bData2, bData3, bData4, bData5, bData6, bData7, bData8, bData9, bData10,
            bData11, bData12, bData13, bData14, bData15, bData16, bData17, bData18, bData19, bData20,
            bData21, bData22, bData23, bData24, bData25, bData26, bData27, bData28, bData29, bData30,
            bData31, bData32, bData33, bData34, bData35, bData36, bData37, bData38, bData39, bData40,
            bData41, bData42, bData43, bData44, bData45, bData46, bData47, bData48, bData49, bData50,
            bData51, bData52, bData53, bData54, bData55, bData56, bData57, bData58, bData59, bData60,
            bData61, bData62, bData63, bData64;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct mgdCANCYCLICTXMSG
    {
        public ushort wCycleTime;
        public byte bIncrMode, bByteIndex;
        public uint dwMsgId;
        public mgdCANMSGINFO uMsgInfo;
        public byte bData1, bData2, bData3, bData4, bData5, bData6, bData7, bData8;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct mgdCANCYCLICTXMSG2
    {
        public ushort wCycleTime;
        public byte bIncrMode, bByteIndex;
        public uint dwMsgId;
        public mgdCANMSGINFO uMsgInfo;
        public byte bData1, bData2, bData3, bData4, bData5, bData6, bData7, bData8, bData9, bData10,
            bData11, bData12, bData13, bData14, bData15, bData16, bData17, bData18, bData19, bData20,
            bData21, bData22, bData23, bData24, bData25, bData26, bData27, bData28, bData29, bData30,
            bData31, bData32, bData33, bData34, bData35, bData36, bData37, bData38, bData39, bData40,
            bData41, bData42, bData43, bData44, bData45, bData46, bData47, bData48, bData49, bData50,
            bData51, bData52, bData53, bData54, bData55, bData56, bData57, bData58, bData59, bData60,
            bData61, bData62, bData63, bData64;
    }
}

namespace Ixxat.Vci4.Bal.Lin
{
    [StructLayout(LayoutKind.Sequential)]
    public struct mgdLINMSGINFO
    {
        public byte bPid, bType, bDlen, bFlags;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct mgdLINMSG
    {
        public uint dwTime;
        public mgdLINMSGINFO uMsgInfo;
        public byte bData1, bData2, bData3, bData4, bData5, bData6, bData7, bData8;
    }
}
#pragma warning restore 1591
