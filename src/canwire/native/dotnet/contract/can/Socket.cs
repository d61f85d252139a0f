// What a CAN line can do and how it is. Source: VCI V3 .NET manual 4.2.2; the contract of Ixxat.Vci4.
#if VCI3
namespace Ixxat.Vci3.Bal.Can
#else
namespace Ixxat.Vci4.Bal.Can
#endif
{
    /// <summary>
    /// What a CAN line can do and how it is; any number of programs may have one. A tick of a timer lasts its divisor
    /// / ClockFrequency seconds; a divisor is 0 where there is no such timer.
    /// </summary>
    public interface ICanSocket : IBalResource
    {
        CanCtrlType ControllerType { get; }

        CanBusCouplings BusCoupling { get; }

        uint ClockFrequency { get; }

        uint TimeStampCounterDivisor { get; }

        uint CyclicMessageTimerDivisor { get; }

        uint MaxCyclicMessageTicks { get; }

        uint DelayedTXTimerDivisor { get; }

        uint MaxDelayedTXTicks { get; }

#if VCI3
        /// <summary>CyclicMessageTimerDivisor and MaxCyclicMessageTicks, as the manual's text calls them.</summary>
        uint CyclicMessageTimeDivisor { get; }

        uint MaxCyclicMsgTicks { get; }
#endif

        CanLineStatus LineStatus { get; }

        CanFeatures Features { get; }

        bool SupportsStdOrExtFrames { get; }

        bool SupportsStdAndExtFrames { get; }

        bool SupportsRemoteFrames { get; }

        bool SupportsErrorFrames { get; }

        bool SupportsBusLoadComputation { get; }

        bool SupportsExactMessageFilter { get; }

        bool SupportsListenOnlyMode { get; }

        bool SupportsCyclicMessageScheduler { get; }

        bool SupportsErrorFrameGeneration { get; }

        bool SupportsDelayedTransmission { get; }
    }

#if !VCI3
    /// <summary>The same of a CAN FD line.</summary>
    public interface ICanSocket2 : IBalResource
    {
        CanCtrlType ControllerType { get; }

        CanBusCouplings BusCoupling { get; }

        CanFeatures Features { get; }

        uint CanClockFrequency { get; }

        CanBitrate2 MinimumArbitrationBitrate { get; }

        CanBitrate2 MaximumArbitrationBitrate { get; }

        CanBitrate2 MinimumFastDataBitrate { get; }

        CanBitrate2 MaximumFastDataBitrate { get; }

        uint TimeStampCounterClockFrequency { get; }

        uint TimeStampCounterDivisor { get; }

        uint CyclicMessageTimerClockFrequency { get; }

        uint CyclicMessageTimerDivisor { get; }

        uint MaxCyclicMessageTicks { get; }

        uint DelayedTXTimerClockFrequency { get; }

        uint DelayedTXTimerDivisor { get; }

        uint MaxDelayedTXTicks { get; }

        CanLineStatus2 LineStatus { get; }

        bool SupportsStdOrExtFrames { get; }

        bool SupportsStdAndExtFrames { get; }

        bool SupportsRemoteFrames { get; }

        bool SupportsErrorFrames { get; }

        bool SupportsBusLoadComputation { get; }

        bool SupportsExactMessageFilter { get; }

        bool SupportsListenOnlyMode { get; }

        bool SupportsCyclicMessageScheduler { get; }

        bool SupportsErrorFrameGeneration { get; }

        bool SupportsDelayedTransmission { get; }

        bool SupportsSingleShotMessages { get; }

        bool SupportsHighPriorityMessages { get; }

        bool SupportsAutoBaudrateDetection { get; }

        bool SupportsExtendedDataLength { get; }

        bool SupportsFastDataRate { get; }

        bool SupportsIsoCanFdFrames { get; }

        bool SupportsNonIsoCanFdFrames { get; }

        bool Supports64BitTimeStamps { get; }
    }
#endif
}
