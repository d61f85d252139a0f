// A message each way between this program and one in Python, on one bus; then this program stays until its input ends.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Classic
{
    static void Main()
    {
        IBalObject board = Boards.Open(0);
        var control = Boards.Socket<ICanControl>(board, 0);
        var channel = Boards.Socket<ICanChannel>(board, 0);
        Boards.Is(board.Resources[0].BusName + board.Resources[1].BusName + board.Resources[2].BusName, "CAN-1CAN-2LIN-1", "names");
        control.InitLine(CanOperatingModes.Standard | CanOperatingModes.Extended | CanOperatingModes.ErrFrame, CanBitrate.Cia500KBit);
        Boards.Is(control.LineStatus.Bitrate, CanBitrate.Cia500KBit, "bit rate");
        Boards.That(control.LineStatus.IsInInitMode && control.SupportsStdAndExtFrames, "offline");
        channel.Initialize(1024, 128, false);
        ICanMessageReader reader = channel.GetMessageReader();
        ICanMessageWriter writer = channel.GetMessageWriter();
        var received = new AutoResetEvent(false);
        reader.Threshold = 1;
        reader.AssignEvent(received);
        channel.Activate();
        control.StartLine();
        Console.WriteLine("started");
        Boards.Is(Console.ReadLine(), "go", "input");

        var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
        message.Identifier = 0x123;
        message.DataLength = 2;
        message[0] = 0xCA;
        message[1] = 0xFE;
        Boards.That(writer.SendMessage(message), "sent");
        ICanMessage answer = Next(reader, received);
        Boards.Is(answer.Identifier, 0x18DAF110u, "identifier");
        Boards.That(answer.ExtendedFrameFormat && answer.DataLength == 8 && answer[7] == 8, "29 bits, 8 bytes");
        Boards.Is(answer.AcceptReason, CanMsgAccReason.Filter1, "filter");
        Console.WriteLine(answer.ToString().Substring(answer.ToString().IndexOf(':')));
        Console.ReadLine();
        reader.Dispose();
        writer.Dispose();
        channel.Dispose();
        control.Dispose();
        board.Dispose();
        Boards.Is(reader.FillCount, (ushort)0, "fill of a disposed reader");
        Console.WriteLine("done");
    }

    static ICanMessage Next(ICanMessageReader reader, AutoResetEvent received)
    {
        while (true)
        {
            ICanMessage[] messages;
            int count = reader.ReadMessages(out messages);
            for (int at = 0; at < count; at++)
                if (messages[at].FrameType == CanMsgFrameType.Data)
                    return messages[at];
            Boards.That(received.WaitOne(Boards.Long, false), "the event is set");
        }
    }
}
