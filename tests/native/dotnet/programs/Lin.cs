// A LIN master asks, a slave answers from its response table, and a monitor hears both.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Lin;

static class LinProgram
{
    static ILinMessage Message(byte id, params byte[] data)
    {
        var made = (ILinMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ILinMessage));
        made.ProtId = id;
        made.DataLength = (byte)data.Length;
        for (int at = 0; at < data.Length; at++)
            made[at] = data[at];
        return made;
    }

    static ILinControl Started(IBalObject board, byte port, LinOperatingModes mode, ILinMessage response)
    {
        var control = Boards.Socket<ILinControl>(board, port);
        control.InitLine(new LinInitLine { OperatingMode = mode | LinOperatingModes.Errors, Bitrate = LinBitrate.Lin19200Bit });
        if (response != null)
            control.WriteMessage(false, response);
        control.StartLine();
        return control;
    }

    static void Main()
    {
        IBalObject one = Boards.Open(0), other = Boards.Open(1);
        var monitor = Boards.Socket<ILinMonitor>(one, 2);
        Boards.That(monitor.SupportsMasterMode && monitor.ClockFrequency > 0, "features");
        monitor.Initialize(100, false);
        ILinMessageReader reader = monitor.GetMessageReader();
        var received = new ManualResetEvent(false);
        reader.AssignEvent(received);
        monitor.Activate();
        ILinControl slave = Started(other, 2, LinOperatingModes.Slave, Message(0x12, 1, 2, 3));
        ILinControl master = Started(one, 2, LinOperatingModes.Master, null);
        Boards.That(master.LineStatus.IsInMasterMode && slave.LineStatus.IsInSlaveMode, "modes");
        ILinMessage header = Message(0x12, 0, 0, 0);
        header.IdOnly = true;
        master.WriteMessage(true, header);
        ILinMessage heard = null;
        while (heard == null)
        {
            ILinMessage next;
            while (heard == null && reader.ReadMessage(out next))
                if (next.MessageType == LinMessageType.Data)
                    heard = next;
            Boards.That(heard != null || received.WaitOne(Boards.Long), "an answer comes");
            received.Reset();
        }
        Boards.Is(heard.ProtId & 0x3F, 0x12, "identifier");
        Boards.That(heard.DataLength == 3 && heard[0] == 1 && heard[2] == 3 && !heard.SenderOfResponse, "the slave's bytes");
        Console.WriteLine("master, slave and monitor");
    }
}
