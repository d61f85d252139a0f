// Manual 002's listings (4.2.3.1, 4.2.3.2, 4.2.4.1), as printed but for the misprint `message` for `messages`.
using System;
using System.Threading;
using Ixxat.Vci3;
using Ixxat.Vci3.Bal;
using Ixxat.Vci3.Bal.Can;

static class Version3
{
    static int seen;
    static CanMessage last;

    static void DoMessages(ICanMessageReader reader)
    {
        CanMessage message;

        while (reader.ReadMessage(out message))
        {
            seen++;
            last = message;
        }
    }

    static void DoMessagesInBlocks(ICanMessageReader reader)
    {
        CanMessage[] messages = new CanMessage[10];

        int readCount = reader.ReadMessages(messages);
        for (int i = 0; i < readCount; i++)
        {
            seen++;
            last = messages[i];
        }
    }

    static bool SendMessage(ICanMessageWriter writer, UInt32 id, Byte data)
    {
        CanMessage message = new CanMessage();

        // Initialize CAN message.
        message.TimeStamp = 0; // no delayed transmission
        message.Identifier = id; // Message ID (CAN-ID)
        message.FrameType = CanMsgFrameType.Data;
        message.SelfReceptionRequest = false; // no self-reception
        message.ExtendedFrameFormat = false; // Standard Frame
        message.DataLength = 1; // only 1 databyte
        message[0] = data;

        // send message
        return writer.SendMessage(message);
    }

    static bool Send(ICanMessageWriter writer)
    {
        CanMessage[] messages = new CanMessage[3];

        // Initialize CAN messages.
        messages[0].Identifier = 0x100;
        messages[0].DataLength = 0;

        messages[1].Identifier = 0x200;
        messages[1].DataLength = 3;
        messages[1].RemoteTransmissionRequest = true;

        messages[2].Identifier = 0x300;
        messages[2].DataLength = 2;
        messages[2][0] = 0x01;
        messages[2][1] = 0xAF;

        return (messages.Length == writer.SendMessages(messages));
    }

    static void AutoInitLine(ICanControl control)
    {
        // Determine bitrate
        int index = control.DetectBaud(100, CanBitrate.CiaBitRates);

        if (-1 < index)
        {
            CanOperatingModes mode;
            mode = CanOperatingModes.Standard | CanOperatingModes.ErrFrame;
            control.InitLine(mode, CanBitrate.CiaBitRates[index]);
        }
    }

    static void Wait(ICanMessageReader reader, AutoResetEvent received, Action<ICanMessageReader> read, int count)
    {
        for (seen = 0; seen < count; read(reader))
            Boards.That(reader.FillCount > 0 || received.WaitOne(Boards.Long), "messages come");
    }

    static void Main()
    {
        IBalObject one = Boards.Open(0), other = Boards.Open(1);
        var sends = Boards.Socket<ICanControl>(one, 0);
        var hears = Boards.Socket<ICanControl>(other, 0);
        Boards.Is(hears.DetectBaud(1, CanBitrate.CiaBitRates), -1, "a silent bus");
        sends.InitLine(CanOperatingModes.Standard, CanBitrate.Cia250KBit);
        sends.StartLine();
        var channel = Boards.Socket<ICanChannel>(one, 0);
        channel.Initialize(100, 100, false);
        channel.Activate();
        ICanMessageWriter writer = channel.GetMessageWriter();
        Boards.That(SendMessage(writer, 0x55, 1), "sent, and repeated until somebody acknowledges");
        AutoInitLine(hears);
        Boards.Is(hears.LineStatus.Bitrate, CanBitrate.Cia250KBit, "the rate that was found");
        var listener = Boards.Socket<ICanChannel>(other, 0);
        listener.Initialize(100, 100, false);
        ICanMessageReader reader = listener.GetMessageReader();
        var received = new AutoResetEvent(false);
        reader.AssignEvent(received);
        reader.Threshold = 1;
        listener.Activate();
        hears.StartLine();
        while (last.Identifier != 0x55)
            Wait(reader, received, DoMessages, 1);
        Boards.Is(last[0], (byte)1, "data");
        Boards.That(Send(writer), "sent three");
        while (last.Identifier != 0x300)
            Wait(reader, received, DoMessagesInBlocks, 1);
        Boards.That(last.DataLength == 2 && last[1] == 0xAF, "two bytes");

        var list = Boards.Socket<ICanScheduler>(one, 0);
        var cyclic = new CanCyclicTXMsg { Identifier = 0x400, DataLength = 8, CycleTicks = 1 };
        cyclic.AutoIncrementMode = CanCyclicTXIncMode.Inc16;
        cyclic[0] = 0xFF;
        list.AddMessage(cyclic);
        list.StartMessage(cyclic, 2);
        list.Resume();
        Wait(reader, received, DoMessages, 2);
        Boards.That(last.Identifier == 0x400 && last[0] == 0 && last[1] == 1, "counted up");
        list.UpdateStatus();
        Boards.Is(cyclic.Status, CanCyclicTXStatus.Done, "status");
        list.RemoveMessage(cyclic);
        Boards.Throws<ArgumentException>(() => list.StartMessage(cyclic, 1), "a message off the list");
        Boards.That(one.Resources.Count == 3 && (int)VciBusType.FlexRay == 3 && (int)CanMsgError.Other == 7, "V3's numbers");
        Console.WriteLine("V3's listings did what they say");
    }
}
