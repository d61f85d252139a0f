// How a LIN line or a monitor was when somebody asked. Source: VCI V3 .NET manual 4.3; contract of Ixxat.Vci4.

#if VCI3
namespace Ixxat.Vci3.Bal.Lin
#else
namespace Ixxat.Vci4.Bal.Lin
#endif
{
    /// <summary>A LIN line; Bitrate is in bit/s.</summary>
    public struct LinLineStatus
    {
        private readonly LinOperatingModes opmode;
        private readonly byte busload;
        private readonly LinCtrlStatus ctrlstat;
        private readonly uint bitrate;

        public LinLineStatus(LinOperatingModes opmode, byte busload, LinCtrlStatus ctrlstat, uint bitrate)
        {
            this.opmode = opmode;
            this.busload = busload;
            this.ctrlstat = ctrlstat;
            this.bitrate = bitrate;
        }

        public LinOperatingModes OperatingMode
        {
            get { return opmode; }
        }

        /// <summary>In percent.</summary>
        public byte Busload
        {
            get { return busload; }
        }

        public LinCtrlStatus ControllerStatus
        {
            get { return ctrlstat; }
        }

        public uint Bitrate
        {
            get { return bitrate; }
        }

        public bool IsInSlaveMode
        {
            get { return !IsInMasterMode; }
        }

        public bool IsInMasterMode
        {
            get { return (opmode & LinOperatingModes.Master) != 0; }
        }

        public bool IsErrModeEnabled
        {
            get { return (opmode & LinOperatingModes.Errors) != 0; }
        }

        public bool HasDataOverrun
        {
            get { return (ctrlstat & LinCtrlStatus.Overrun) != 0; }
        }

        public bool IsInInitMode
        {
            get { return (ctrlstat & LinCtrlStatus.InInit) != 0; }
        }

        public override string ToString()
        {
            return string.Format("opmode: {0}, busload: {1}, ctrlstat: {2}, bitrate: {3}", opmode, busload, ctrlstat, bitrate);
        }
    }

    /// <summary>A monitor.</summary>
    public struct LinMonitorStatus
    {
        private readonly bool activated;
        private readonly bool rxoverrun;
        private readonly byte fifoload;

        public LinMonitorStatus(bool activated, bool rxoverrun, byte fifoload)
        {
            this.activated = activated;
            this.rxoverrun = rxoverrun;
            this.fifoload = fifoload;
        }

        public bool IsActivated
        {
            get { return activated; }
        }

        /// <summary>Messages were lost since Initialize.</summary>
        public bool HasFifoOverrun
        {
            get { return rxoverrun; }
        }

        /// <summary>In percent.</summary>
        public byte ReceiveFifoLoad
        {
            get { return fifoload; }
        }

        public override string ToString()
        {
            return string.Format("active: {0}, overrun: {1}, fifoload: {2:X2}", activated, rxoverrun, fifoload);
        }
    }
}
