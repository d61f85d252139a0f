// The first board's first CAN connector: send a message, and hear it come back once somebody has acknowledged it.
//
// mcs examples/native/First.cs $(canwire native dotnet --libs) -out:first.exe
// MONO_PATH=$(canwire native dotnet --libraries) mono first.exe
using System;
using System.Collections;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;

static class First
{
    static void Main()
    {
        using (IVciDeviceManager manager = VciServer.Instance().DeviceManager)
        using (IVciDeviceList list = manager.GetDeviceList())
        {
            IEnumerator devices = list.GetEnumerator();
            if (!devices.MoveNext())
                throw new Exception("there is no board");
            using (var device = (IVciDevice)devices.Current)
            using (IBalObject board = device.OpenBusAccessLayer())
            using (var control = (ICanControl)board.OpenSocket(0, typeof(ICanControl)))
            using (var channel = (ICanChannel)board.OpenSocket(0, typeof(ICanChannel)))
            {
                channel.Initialize(1024, 128, false);
                channel.Activate();
                control.InitLine(CanOperatingModes.Standard | CanOperatingModes.Extended, CanBitrate.Cia500KBit);
                control.StartLine();
                Console.WriteLine("{0}: {1}", device.Description, Echo(channel));
            }
        }
    }

    static string Echo(ICanChannel channel)
    {
        using (ICanMessageReader reader = channel.GetMessageReader())
        using (ICanMessageWriter writer = channel.GetMessageWriter())
        using (var received = new AutoResetEvent(false))
        {
            reader.Threshold = 1;
            reader.AssignEvent(received);
            var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
            message.Identifier = 0x123;
            message.DataLength = 2;
            message[0] = 0xCA;
            message[1] = 0xFE;
            message.SelfReceptionRequest = true;
            writer.SendMessage(message);
            while (received.WaitOne(5000))
                while (reader.ReadMessage(out message))
                    if (message.FrameType == CanMsgFrameType.Data)
                        return string.Format("{0:X3} {1:X2}{2:X2}", message.Identifier, message[0], message[1]);
            throw new Exception("nobody acknowledged the message");
        }
    }
}
