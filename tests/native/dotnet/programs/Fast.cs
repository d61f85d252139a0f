// CAN FD: 64 bytes at two rates, the channel's own filter, and a cyclic message that counts up.
using System;
using System.Collections.Generic;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Fast
{
    static IBalObject board;

    static ICanControl2 Started(byte port)
    {
        var control = Boards.Socket<ICanControl2>(board, port);
        control.InitLine(CanOperatingModes.Standard | CanOperatingModes.Extended,
            CanExtendedOperatingModes.ExtendedDataLength | CanExtendedOperatingModes.FastDataRate,
            CanFilterModes.Pass, 0, CanFilterModes.Pass, 0, CanBitrate2.CANFD500KBit, CanBitrate2.CANFD2000KBit);
        control.StartLine();
        return control;
    }

    static ICanChannel2 Active(byte port, CanFilterModes filter)
    {
        var channel = Boards.Socket<ICanChannel2>(board, port);
        channel.Initialize(1000, 100, 100, filter, false);
        if (filter == CanFilterModes.Inclusive)
        {
            channel.SetAccFilter(CanFilter.Std, (uint)CanAccCode.None, (uint)CanAccMask.None);
            channel.AddFilterIds(CanFilter.Std, 0x200 << 1, 0x700 << 1);
        }
        Boards.Is(channel.GetFilterMode(CanFilter.Std), (byte)filter, "filter mode");
        channel.Activate();
        return channel;
    }

    static List<ICanMessage2> Data(ICanMessageReader reader, AutoResetEvent received, int count)
    {
        var found = new List<ICanMessage2>();
        while (found.Count < count)
        {
            ICanMessage2 one;
            while (reader.ReadMessage(out one))
                if (one.FrameType == CanMsgFrameType.Data)
                    found.Add(one);
            if (found.Count < count)
                Boards.That(received.WaitOne(Boards.Long), "messages come");
        }
        return found;
    }

    static void Main()
    {
        board = Boards.Open(0);
        ICanControl2 one = Started(0), other = Started(1);
        Boards.That(one.SupportsExtendedDataLength && one.SupportsFastDataRate && one.SupportsIsoCanFdFrames, "FD");
        Boards.Is(one.LineStatus.FastBitrate.Prescaler, 2000000u, "fast rate");
        ICanChannel2 sends = Active(0, CanFilterModes.Pass), hears = Active(1, CanFilterModes.Inclusive);
        ICanMessageWriter writer = sends.GetMessageWriter();
        ICanMessageReader reader = hears.GetMessageReader();
        var received = new AutoResetEvent(false);
        reader.AssignEvent(received);
        for (uint id = 0x1FF; id <= 0x201; id++) // the channel's filter stops the first one
        {
            var message = (ICanMessage2)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage2));
            message.Identifier = id;
            message.ExtendedDataLength = message.FastDataRate = true;
            message.DataLength = 60; // there is no such length: 64
            message[63] = (byte)id;
            Boards.That(writer.SendMessage(message), "sent");
        }
        List<ICanMessage2> got = Data(reader, received, 2);
        Boards.Is(got[0].Identifier, 0x200u, "the first one let through");
        Boards.That(got[1].ExtendedDataLength && got[1].FastDataRate && got[1].DataLength == 64 && got[1][63] == 1, "64 bytes");

        using (var list = Boards.Socket<ICanScheduler2>(board, 0))
        {
            ICanCyclicTXMsg2 cyclic = list.AddMessage();
            cyclic.Identifier = 0x210;
            cyclic.DataLength = 1;
            cyclic.CycleTicks = 2;
            cyclic.AutoIncrementMode = CanCyclicTXIncMode.Inc8;
            Boards.Is(cyclic.Status, CanCyclicTXStatus.Empty, "status before the start");
            cyclic.Start(3);
            got = Data(reader, received, 3);
            Boards.That(got[0][0] == 0 && got[1][0] == 1 && got[2][0] == 2, "counted up");
            Boards.Is(cyclic.Status, CanCyclicTXStatus.Done, "status at the end");
            Boards.Throws<VciException>(() => Boards.Socket<ICanScheduler2>(board, 0), "a second list");
        }
        Console.WriteLine("two rates, filters and a cyclic list");
    }
}
