// What sets a CAN line up. Source: VCI V3 .NET manual 4.2.4; the vendor's published contract of Ixxat.Vci4.
#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>
    /// The control unit of a line; one program at a time may have it. Undefined, InitLine or DetectBaud, offline,
    /// StartLine, online, StopLine or ResetLine, offline. Filters compare identifier &lt;&lt; 1 | RTR, offline alone.
    /// </summary>
    public interface ICanControl : ICanSocket
    {
        /// <summary>
        /// Index of the bit rate that the running bus speaks, after up to `timeout` ms for each of them. Where nothing is
        /// heard, V3 gives -1 and V4 throws VciException with VCI_E_TIMEOUT.
        /// </summary>
        int DetectBaud(ushort timeout, CanBitrate[] bitrateTable);

        void InitLine(CanOperatingModes operatingMode, CanBitrate bitrate);

        void ResetLine();

        void StartLine();

        void StopLine();

        void SetAccFilter(CanFilter select, uint code, uint mask);

        void AddFilterIds(CanFilter select, uint code, uint mask);

        void RemFilterIds(CanFilter select, uint code, uint mask);
    }

#if !VCI3
    /// <summary>The control unit of a CAN FD line.</summary>
    public interface ICanControl2 : ICanSocket2
    {
        int DetectBaud(CanOperatingModes operatingMode, CanExtendedOperatingModes extendedMode, ushort timeout,
            CanFdBitrate[] bitrateTable);

        void InitLine(CanOperatingModes operatingMode, CanExtendedOperatingModes extendedMode,
            CanFilterModes filterModeStd, uint cntIdsStd, CanFilterModes filterModeExt, uint cntIdsExt,
            CanBitrate2 bitrate, CanBitrate2 extendedBitrate);

        void ResetLine();

        void StartLine();

        void StopLine();

        void SetAccFilter(CanFilter select, uint code, uint mask);

        void AddFilterIds(CanFilter select, uint code, uint mask);

        void RemFilterIds(CanFilter select, uint code, uint mask);
    }
#endif
}
