// What is refused, and by which exception.
using System;
using System.Collections;
using System.Threading;
using Ixxat.Vci4;
using Ixxat.Vci4.Bal;
using Ixxat.Vci4.Bal.Can;
using Ixxat.Vci4.Bal.Lin;

static class Errors
{
    static void Lists()
    {
        IVciDeviceManager manager = VciServer.Instance().DeviceManager;
        IVciDeviceList list = manager.GetDeviceList();
        IEnumerator enumerator = list.GetEnumerator();
        object current;
        Boards.Throws<InvalidOperationException>(() => current = enumerator.Current, "Current before the first board");
        Boards.That(enumerator.MoveNext(), "there is a board");
        Boards.Is(enumerator.Current, enumerator.Current, "Current, asked twice");
        var device = (IVciDevice)enumerator.Current;
        Boards.That(device.UniqueHardwareId is string && device.Equipment[0].ControllerType is CanCtrlType, "facts of a board");
        Boards.Throws<ArgumentNullException>(() => list.AssignEvent((AutoResetEvent)null), "no event");
        manager.Dispose();
        manager.Dispose();
        Boards.Throws<ObjectDisposedException>(() => manager.GetDeviceList(), "a disposed manager");
        list.Dispose();
        Boards.Throws<ObjectDisposedException>(() => list.GetEnumerator(), "a disposed list");
        device.Dispose();
        Boards.Throws<ObjectDisposedException>(() => device.OpenBusAccessLayer(), "a disposed board");
    }

    static void Sockets(IBalObject board)
    {
        Boards.Throws<ArgumentOutOfRangeException>(() => board.OpenSocket(99, typeof(ICanSocket)), "connector 99");
        Boards.Throws<NotImplementedException>(() => board.OpenSocket(0, typeof(ILinSocket)), "LIN on CAN");
        Boards.Throws<NotImplementedException>(() => board.OpenSocket(0, typeof(string)), "a string");
        Boards.Throws<ArgumentNullException>(() => board.OpenSocket(0, null), "no type");
        var control = Boards.Socket<ICanControl>(board, 0);
        Boards.Refused(VciError.VCI_E_ACCESSDENIED, () => Boards.Socket<ICanControl>(board, 0), "a second control unit");
        Boards.Throws<VciException>(() => control.StartLine(), "an undefined line");
        Boards.Refused(VciError.VCI_E_INVALIDARG, () => control.DetectBaud(10, null), "no bit rates");
        Boards.Refused(VciError.VCI_E_TIMEOUT, () => control.DetectBaud(10, CanBitrate.CiaBitRates), "a silent bus");
        control.InitLine(CanOperatingModes.Standard, CanBitrate.Cia500KBit);
        control.ResetLine();
        Boards.Is(control.LineStatus.Bitrate.Name, "CiA 500 kbit/s", "the rate after ResetLine");
        control.Dispose();
        control.Dispose();
        Boards.Throws<ObjectDisposedException>(() => control.StartLine(), "a disposed control unit");
        Boards.Is(control.BusName, "CAN-1", "the name of a disposed one");
    }

    static void Channels(IBalObject board)
    {
        var channel = Boards.Socket<ICanChannel>(board, 0);
        Boards.Throws<ObjectDisposedException>(() => channel.Activate(), "a channel without FIFOs");
        channel.Initialize(10, 10, true);
        using (var second = Boards.Socket<ICanChannel>(board, 0))
            Boards.Refused(VciError.VCI_E_ACCESSDENIED, () => second.Initialize(10, 10, false), "beside an exclusive one");
        ICanMessageReader reader = channel.GetMessageReader();
        Boards.Throws<VciException>(() => channel.GetMessageReader(), "a second reader");
        Boards.Throws<VciException>(() => reader.Unlock(), "Unlock without Lock");
        ICanMessageWriter writer = channel.GetMessageWriter();
        var message = (ICanMessage)VciServer.Instance().MsgFactory.CreateMsg(typeof(ICanMessage));
        Boards.Throws<ArgumentOutOfRangeException>(() => message.DataLength = 9, "nine bytes");
        Boards.Throws<ArgumentOutOfRangeException>(() => message[8] = 1, "byte 8");
        Boards.Throws<ArgumentException>(() => writer.SendMessage((ICanMessage)null), "no message");
        int sent = 0;
        while (writer.SendMessage(message))
            sent++;
        Boards.Is(sent, writer.Capacity, "messages that fit");
        Boards.Is(writer.FreeCount, (ushort)0, "room");
        reader.Dispose();
        Boards.Throws<ObjectDisposedException>(() => reader.ReadMessage(out message), "a disposed reader");
        channel.Dispose();
    }

    static void Main()
    {
        Lists();
        using (IBalObject board = Boards.Open(0))
        {
            Sockets(board);
            Channels(board);
        }
        Boards.Throws<ArgumentException>(() => VciServer.Instance().MsgFactory.CreateMsg(typeof(int)), "a message of int");
        Boards.That(VciServer.Instance().GetErrorMsg(unchecked((int)VciError.VCI_E_TIMEOUT)).Contains("VCI_E_TIMEOUT"), "text");
        Boards.That(new VciException(VciServer.Instance(), 5).HResult == 5, "the number");
        Console.WriteLine("every mistake has its exception");
    }
}
