// What kinds.py does, in C#: Keeper.exe PLACE NUMBER; words on its input, its account as a line of JSON.
using System;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class Keeper
{
    static ICanMessageReader reader;
    static ICanMessageWriter writer;
    static long taken, turnedAway, got, others, lost;
    static volatile bool sends, asked, over;

    static void Open(string place)
    {
        using (IVciDeviceManager manager = VciServer.Instance().DeviceManager)
        using (IVciDeviceList list = manager.GetDeviceList())
            foreach (IVciDevice device in list)
                if (device.UniqueHardwareId.ToString() == place)
                {
                    IBalObject board = device.OpenBusAccessLayer();
                    var control = (ICanControl)board.OpenSocket(0, typeof(ICanControl));
                    control.InitLine(CanOperatingModes.Standard, CanBitrate.Cia500KBit);
                    var channel = (ICanChannel)board.OpenSocket(0, typeof(ICanChannel));
                    channel.Initialize(60000, 64, false);
                    channel.Activate();
                    reader = channel.GetMessageReader();
                    writer = channel.GetMessageWriter();
                    control.StartLine();
                    return;
                }
        throw new Exception("there is no board " + place);
    }

    static void ReadAll()
    {
        ICanMessage message;
        while (reader.ReadMessage(out message))
        {
            if (message.FrameType == CanMsgFrameType.Data)
                got++;
            else
                others++;
            if (message.PossibleOverrun)
                lost += 1000000; // it does not say how many
        }
    }

    static void SendOne(uint id)
    {
        var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
        message.Identifier = id;
        message.DataLength = 4;
        for (int k = 0; k < 4; k++)
            message[k] = (byte)(taken >> 8 * k);
        if (writer.SendMessage(message))
            taken++;
        else
            turnedAway++;
    }

    static void Hear()
    {
        string word;
        while ((word = Console.ReadLine()) != null)
            if (word == "account")
                asked = true;
            else
                sends = word == "go";
        over = true;
    }

    static void Main(string[] words)
    {
        Open(words[0]);
        Console.WriteLine("at it");
        new Thread(Hear) { IsBackground = true }.Start();
        var watch = System.Diagnostics.Stopwatch.StartNew();
        for (long next = 0; !over; Thread.Sleep(50))
        {
            ReadAll();
            if (sends && watch.ElapsedMilliseconds >= next)
            {
                next = watch.ElapsedMilliseconds + 100;
                SendOne(0x100 + uint.Parse(words[1]));
            }
            if (asked)
            {
                asked = false;
                ReadAll();
                Console.WriteLine("{{\"taken\": {0}, \"turned_away\": {1}, \"got\": {2}, \"others\": {3}, \"lost\": {4}, \"waiting\": 0}}",
                    taken, turnedAway, got, others, lost);
            }
        }
    }
}
