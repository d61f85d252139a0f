// 3,000 messages from one thread to another over the bus, in order and none lost, while memory is collected.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Stream
{
    const uint Count = 3000;

    static ICanChannel Active(IBalObject board, byte port, ushort receives)
    {
        var control = Boards.Socket<ICanControl>(board, port);
        control.InitLine(CanOperatingModes.Extended, CanBitrate.Cia1000KBit);
        var channel = Boards.Socket<ICanChannel>(board, port);
        channel.Initialize(receives, 64, false);
        channel.Activate();
        control.StartLine();
        return channel;
    }

    static void Send(ICanMessageWriter writer, AutoResetEvent room)
    {
        var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
        message.ExtendedFrameFormat = true;
        for (uint number = 0; number < Count; number++)
        {
            message.Identifier = number;
            while (!writer.SendMessage(message))
                Boards.That(room.WaitOne(Boards.Long), "there is room again");
        }
    }

    static void Main()
    {
        IBalObject board = Boards.Open(0);
        ICanChannel sends = Active(board, 0, 10), hears = Active(board, 1, 4000);
        ICanMessageWriter writer = sends.GetMessageWriter();
        ICanMessageReader reader = hears.GetMessageReader();
        AutoResetEvent received = new AutoResetEvent(false), room = new AutoResetEvent(false);
        writer.Threshold = 32;
        writer.AssignEvent(room);
        reader.AssignEvent(received);
        var sender = new Thread(() => Send(writer, room));
        sender.Start();
        for (uint expected = 0; expected < Count;)
        {
            ICanMessage[] messages;
            int count = reader.ReadMessages(out messages);
            for (int at = 0; at < count; at++)
                if (messages[at].FrameType == CanMsgFrameType.Data)
                    Boards.Is(messages[at].Identifier, expected++, "the next message");
            GC.Collect();
            if (count == 0)
                Boards.That(received.WaitOne(Boards.Long), "messages come");
        }
        sender.Join();
        Boards.That(!hears.ChannelStatus.HasFifoOverrun, "nothing was lost");
        Console.WriteLine("all of them in order");
    }
}
